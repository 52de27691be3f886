// The layout is a promise to programs already compiled: offsets are spelled out here by hand.
#include <gtest/gtest.h>

#include "proto/shm_layout.h"
#include "proto/snapshot.h"

namespace {

TEST(Layout, HeaderOffsetsStay) {
  EXPECT_EQ(offsetof(hd_shm_header, magic), 0u);
  EXPECT_EQ(offsetof(hd_shm_header, major), 8u);
  EXPECT_EQ(offsetof(hd_shm_header, minor), 10u);
  EXPECT_EQ(offsetof(hd_shm_header, daemon_epoch), 24u);
  EXPECT_EQ(offsetof(hd_shm_header, ready), 76u);
}

TEST(Layout, SampleOffsetsStay) {
  EXPECT_EQ(offsetof(hd_sample, t_ns), 16u);
  EXPECT_EQ(offsetof(hd_sample, p), 40u);
  EXPECT_EQ(offsetof(hd_sample, q), 64u);
  EXPECT_EQ(offsetof(hd_sample, proxy), 144u);
  EXPECT_EQ(offsetof(hd_sample, force), 168u);
  EXPECT_EQ(offsetof(hd_sample, by_source), 216u);
}

TEST(Layout, RegionOffsetsStay) {
  EXPECT_EQ(offsetof(hd_region_a, acks), 128u);
  EXPECT_EQ(offsetof(hd_region_a, counters), 256u);
  EXPECT_EQ(offsetof(hd_region_a, models), 384u);
  EXPECT_EQ(offsetof(hd_region_a, history_tail), 640u);
  EXPECT_EQ(offsetof(hd_region_a, latest), 768u);
  EXPECT_EQ(offsetof(hd_region_a, history), 768u + 4 * 384);
  EXPECT_EQ(offsetof(hd_region_b, tail), 128u);
  EXPECT_EQ(offsetof(hd_region_b, heartbeat_ns), 256u);
  EXPECT_EQ(offsetof(hd_region_b, mailbox), 384u + 256 * 512);
}

TEST(Layout, SnapshotIsPackedAsPromised) {
  EXPECT_EQ(sizeof(hd_bvh_node), 256u);
  EXPECT_EQ(sizeof(hd_mesh_upload), 24u);
  EXPECT_EQ(sizeof(hd_snapshot_header), 80u + 16 * HD_SECTIONS);
}

}  // namespace
