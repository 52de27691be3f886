/** @file
 * Every key of the configuration, once: reader, writer and tests walk the same list.
 *
 * A visitor has number, integer, flag, text, mode, level, texts, integers and triple for values (each given key, value
 * and, where there is one, the range), table for a section and tables for an array of sections.
 */
#pragma once

#include "daemon/config/config.h"
#include "proto/shm_layout.h"

namespace hapticd {

template <class Visitor, class Limits>
void visitLimits(Visitor& v, Limits& c) {
  const auto number = [&](const char* name, auto& value, const LimitsConfig::Range& range) {
    v.number(name, value, range.least, range.most);
  };
  number("force_n", c.force_n, LimitsConfig::kForce);
  number("torque_nm", c.torque_nm, LimitsConfig::kTorque);
  number("gripper_force_n", c.gripper_force_n, LimitsConfig::kGripperForce);
  number("force_slew_n_per_s", c.force_slew_n_per_s, LimitsConfig::kForceSlew);
  number("torque_slew_nm_per_s", c.torque_slew_nm_per_s, LimitsConfig::kTorqueSlew);
  number("velocity_m_per_s", c.velocity_m_per_s, LimitsConfig::kVelocity);
  number("power_w", c.power_w, LimitsConfig::kPower);
  number("active_power_w", c.active_power_w, LimitsConfig::kPower);
}

template <class Visitor, class Configuration>
void visitConfig(Visitor& root, Configuration& c) {
  root.table("log", [&](auto& v) { v.level("level", c.log.level); });
  root.table("sockets", [&](auto& v) {
    v.text("control", c.sockets.control);
    v.text("admin", c.sockets.admin);
    v.text("group", c.sockets.group);
    v.mode("mode", c.sockets.mode);
    v.mode("admin_mode", c.sockets.admin_mode);
  });
  root.table("servo", [&](auto& v) {
    v.number("rate_hz", c.servo.rate_hz, 1000, 4000);
    v.integer("servo_priority", c.servo.servo_priority, 2, 98);
    v.integer("ingest_priority", c.servo.ingest_priority, 1, 97);
    v.integer("gpio_priority", c.servo.gpio_priority, 1, 98);
    v.flag("allow_no_rt", c.servo.allow_no_rt);
    v.flag("lock_memory", c.servo.lock_memory);
    v.flag("hold_cpu_latency", c.servo.hold_cpu_latency);
    v.integer("missed_limit", c.servo.missed_limit, 1, 100'000);
  });
  root.table("guard", [&](auto& v) {
    v.number("arm_ramp_ms", c.guard.arm_ramp_ms, 100, 60'000);
    v.number("small_force_n", c.guard.small_force_n, 0.001, 10);
    v.integer("small_force_ticks", c.guard.small_force_ticks, 1, 10'000);
    v.number("device_stale_ms", c.guard.device_stale_ms, 1, 1000);
    v.flag("passivity", c.guard.passivity);
    v.number("motor_heating_s", c.guard.motor_heating_s, 0, 3600);
  });
  root.table("limits", [&](auto& v) { visitLimits(v, c.limits); });
  root.table("sessions", [&](auto& v) {
    v.number("loss_fade_ms", c.sessions.loss_fade_ms, 1, 50);
    v.number("stale_after_ms", c.sessions.stale_after_ms, 50, 10'000);
    v.integer("budget_per_tick", c.sessions.budget_per_tick, 1, 64);
    v.number("max_ahead_s", c.sessions.max_ahead_s, 0, 3600);
    v.integer("event_buffer", c.sessions.event_buffer, 16, 1'000'000);
  });
  root.table("quotas", [&](auto& v) {
    v.integer("sessions", c.quotas.sessions, 1, 16);
    v.number("memory_mb", c.quotas.memory_mb, 2, 1e6);
    v.integer("objects", c.quotas.objects, 0, 255);
    v.integer("triangles", c.quotas.triangles, 0, 16'000'000);
  });
  root.table("builder", [&](auto& v) {
    v.text("program", c.builder.program);
    v.number("memory_mb", c.builder.memory_mb, 64, 1e6);
    v.number("timeout_s", c.builder.timeout_s, 1, 3600);
    v.text("cache", c.builder.cache);
    v.number("cache_mb", c.builder.cache_mb, 0, 1e6);
    v.flag("vdb", c.builder.vdb);
  });
  root.table("motions", [&](auto& v) { v.text("folder", c.motions.folder); });
  root.tables("group", c.groups, [](auto& v, auto& group) {
    v.text("name", group.name);
    v.texts("devices", group.devices);
    v.number("rate_hz", group.rate_hz, 1000, 4000);
    v.integers("cpus", group.cpus, 0, 1023);
  });
  root.tables("device", c.devices, [](auto& v, auto& device) {
    v.text("uri", device.uri);
    v.number("radius_m", device.radius_m, 0, DeviceConfig::kMostRadius);
    v.triple("mount_m", device.mount_m, -DeviceConfig::kMostDistance, DeviceConfig::kMostDistance);
    v.triple("mount_deg", device.mount_deg, -360, 360);
    v.number("scale", device.scale, DeviceConfig::kLeastScale, DeviceConfig::kMostScale);
    v.integer("clutch_button", device.clutch_button, 0, 32);
    v.text("finger", device.finger);
    visitLimits(v, device.limits);
  });
  root.tables("line", c.lines, [](auto& v, auto& line) {
    v.text("role", line.role);
    v.text("chip", line.chip);
    v.text("name", line.name);
    v.flag("active_low", line.active_low);
    v.text("bias", line.bias);
    v.number("debounce_ms", line.debounce_ms, 0, 100);
  });
}

}  // namespace hapticd
