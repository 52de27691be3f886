#include "tools/haptic-bench/trajectory/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/measured/measured.h"
#include "tools/haptic-bench/spec.h"
#include "tools/haptic-bench/trajectory/fit.h"
#include "tools/haptic-bench/trajectory/generators.h"
#include "tools/haptic-bench/trajectory/geodesic.h"
#include "tools/haptic-bench/trajectory/recording_reader.h"

namespace haptic_bench {
namespace {

/** What a generator or reader is given. */
struct Request {
  Spec& spec;
  const Model& model;
  const Surface& surface;

  [[nodiscard]] Pace pace() const {
    return {spec.number("seconds", 10, 0.01, 3600), spec.number("rate", 1000, 1, 1e5),
            spec.number("force", 1, 0, 1000)};
  }
  /** Throws Failure for a hand that is pressed in so far that another side is nearer to it. */
  void refuseMiddle() const {
    const double depth = pace().force / surface.stiffness;
    if (depth < model.radius + surface.radius) return;
    throw Failure(spec.text(),
                  fmt::format("at {:g} N/m the hand is pressed {:g} m in, to the middle of {}", surface.stiffness,
                              depth, model.name),
                  "stiffer, less force, or a larger radius");
  }
  /** Throws Failure unless the model is of that kind. */
  void need(const char* kind) const {
    if (model.kind == kind) return;
    throw Failure(spec.text(), "it runs over a " + std::string(kind) + " at the origin, not over " + model.name,
                  "--model " + std::string(kind) + "; geodesic and files take any, wherever it stands");
  }
};

struct Generator {
  const char* name;
  const char* help;
  std::vector<SurfaceSample> (*make)(const Request& request);
  bool any_mesh = false;  ///< Also a thin one.
};

constexpr Generator kGenerators[] = {
    {"spiral", "spiral:turns=20: pole to pole of a sphere",
     [](const Request& r) {
       r.need("sphere");
       r.refuseMiddle();
       return spiral(r.model, r.pace(), r.spec.number("turns", 20, 0, 1e4));
     }},
    {"lissajous", "lissajous: over a plane",
     [](const Request& r) {
       r.need("plane");
       return lissajous(r.model, r.pace());
     }},
    {"profile", "profile:length=0.06,speed=0.02,y=0.0123: across a ridge, by arc length",
     [](const Request& r) {
       r.need("ridge");
       if (r.spec.has("seconds")) {
         throw Failure(r.spec.text() + ", seconds", "length and speed say how long it takes", "leave it out");
       }
       return profile(r.model, r.pace(), r.spec.number("length", 0.06, 1e-6, 10),
                      r.spec.number("speed", 0.02, 1e-6, 10), r.spec.number("y", 0.0123, -10, 10));
     }},
    {"swing", "swing:speed=0.1: through a bowl, then at rest",
     [](const Request& r) {
       r.need("bowl");
       return swing(r.model, r.pace(), r.spec.number("speed", 0.1, 1e-6, 10));
     }},
    {"reach", "reach:tremor=0.0002,seed=1: minimum jerk with a tremor of 8 to 12 Hz, over a plane",
     [](const Request& r) {
       r.need("plane");
       const Tremor tremor{r.spec.number("tremor", 0.0002, 0, 0.01),
                           static_cast<std::uint32_t>(r.spec.count("seed", 1, 0, 1'000'000'000))};
       return reach(r.model, r.pace(), tremor, r.surface.stiffness);
     }},
    {"geodesic", "geodesic:speed=0.1,azimuth=0.5,x=0,y=0,z=1: a stroke over any mesh, straight on from facet to facet",
     [](const Request& r) {
       const Vec3 from(r.spec.number("x", 0, -100, 100), r.spec.number("y", 0, -100, 100),
                       r.spec.number("z", 1, -100, 100));
       return geodesic(r.model, r.pace(), r.spec.number("speed", 0.1, 1e-6, 10), r.spec.number("azimuth", 0.5, -10, 10),
                       from);
     },
     true},
    {"measured",
     "measured:forces=F.csv,poses=P.csv: a probe's force and pose streams, registered to the model (docs/benchmark.md)",
     [](const Request& r) { return readMeasured(r.spec, r.model); }, true},
};

/** A kind of file: add yours here. */
struct Reader {
  const char* suffix;
  const char* help;
  Trajectory (*read)(const std::string& path, const FileOptions& options, const Model& model, const Surface& surface);
};

Trajectory readTable(const std::string& path, const FileOptions& options, const Model& model, const Surface& surface) {
  return readColumns(Table::read(path, options.columns), options, model, surface);
}

constexpr Reader kReaders[] = {
    {".csv", "FILE.csv: columns by the names in its first line, or by --columns", readTable},
    {".traj", "FILE.traj, .txt, .dat: columns by --columns", readTable},
    {".txt", nullptr, readTable},
    {".dat", nullptr, readTable},
};

/** In capitals too. */
bool endsWith(const std::string& text, const std::string& end) {
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  return text.size() > end.size() &&
         std::equal(end.begin(), end.end(), text.end() - static_cast<std::ptrdiff_t>(end.size()),
                    [&](char b, char a) { return same(a, b); });
}

/** Throws Failure for an option that would do nothing, as a generator's --rate would. */
void refuseIdle(const FileOptions& file, const std::string& what, bool is_table, bool is_recording) {
  const auto refuse = [&](const char* option, bool given, const char* meant) {
    if (given) throw Failure(option, "it does nothing for " + what, std::string("it is for ") + meant);
  };
  constexpr const char* kTables = "files of columns; generators have settings, as spiral:rate=2000";
  refuse("--columns", !is_table && !file.columns.empty(), kTables);
  refuse("--out", !is_table && file.out, kTables);
  refuse("--rate", !is_table && file.rate_hz > 0, kTables);
  refuse("--max-gap", !is_table && file.max_gap_s > 0, kTables);
  refuse("--max-gap", file.rate_hz > 0 && file.max_gap_s > 0, "a file's own times, before which --rate goes");
  refuse("--device", !is_recording && !is_table && file.device > 0, "recordings and their exports");
}

/** With the options that make other samples of the same file: results of two readings are not those of one. */
std::string nameOf(const std::string& text, const FileOptions& file) {
  std::string name = text;
  if (!file.columns.empty()) name += " --columns " + file.columns;
  if (file.out) name += " --out";
  if (file.rate_hz > 0) name += fmt::format(" --rate {}", file.rate_hz);
  if (file.device > 0) name += fmt::format(" --device {}", file.device);
  return name;
}

}  // namespace

std::string trajectoryHelp() {
  std::string help = "Trajectories (also seconds=10, rate=1000, force=1):\n";
  for (const Generator& g : kGenerators) help += std::string("  ") + g.help + "\n";
  for (const Reader& r : kReaders) {
    if (r.help != nullptr) help += std::string("  ") + r.help + "\n";
  }
  return help + "  FILE: a recording of a session, with --device; the truth is the force that was sent\n";
}

Trajectory makeTrajectory(const std::string& text, const Model& model, const Surface& surface,
                          const FileOptions& file) {
  const std::string name = text.substr(0, text.find(':'));
  for (const Generator& g : kGenerators) {
    if (name != g.name) continue;
    refuseIdle(file, text, false, false);
    Spec spec(text);
    const std::vector<SurfaceSample> out = g.make({spec, model, surface});
    spec.finish();
    Trajectory made = pressInto(out, surface);
    judgeWhereItFits(made, out, model, surface.radius, text);
    if (g.any_mesh) tellOfThinPlaces(made, out, model, text);
    // What is measured lies off the mesh, and flat facets lie above a hollow's smooth surface.
    made.start = outside(made.start, model, surface.radius);
    made.name = text;
    countJudged(made);
    return made;
  }
  if (isRecording(text)) {
    refuseIdle(file, text, false, true);
    Trajectory recorded = readRecordedSession(text, file.device);
    recorded.name = nameOf(text, file);
    countJudged(recorded);
    return recorded;
  }
  for (const Reader& r : kReaders) {
    if (!endsWith(text, r.suffix)) continue;
    refuseIdle(file, text, true, false);
    Trajectory read = r.read(text, file, model, surface);
    read.name = nameOf(text, file);
    countJudged(read);
    return read;
  }
  std::error_code none;
  if (std::filesystem::exists(text, none)) {
    throw Failure(text, "it is neither a recording nor, by its name, a file of columns",
                  ".csv, .traj, .txt or .dat; a recording begins with HRBLOCK1");
  }
  throw Failure(text, "there is no such trajectory", "haptic-bench run --help lists them");
}

}  // namespace haptic_bench
