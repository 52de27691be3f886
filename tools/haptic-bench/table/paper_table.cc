#include "tools/haptic-bench/table/paper_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <optional>

#include "tools/haptic-bench/measured/measured.h"
#include "tools/haptic-bench/measured/synthetic.h"
#include "tools/haptic-bench/tell.h"
#include "tools/haptic-bench/trajectory/generators.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"

namespace haptic_bench {
namespace {

constexpr double kThreshold = 0.0005;  // [m]

/** One cell of a comparison: errors exact, times the median of the rounds. */
struct Figures {
  double mse = 0, mean_us = 0, init_s = 0;
};

/** Models with a trajectory each, and the algorithms over them. */
class Cells {
 public:
  Cells(const Surface& surface, std::vector<std::string> algorithms, const std::vector<std::string>& more)
      : surface_(surface), own_(algorithms.size()), algorithms_(withMore(std::move(algorithms), more)) {}

  void add(Model model, Trajectory trajectory) {
    ways_.push_back({std::move(model), std::move(trajectory), {}});
    Way& way = ways_.back();
    for (std::size_t a = 0; a < algorithms_.size(); ++a) {
      const std::string no = a < own_ ? "" : refusal(algorithms_[a], way.model, way.trajectory, surface_);
      way.trials.push_back(no.empty() ? &trials_.emplace_back(algorithms_[a], way.model, way.trajectory, surface_)
                                      : nullptr);
      if (!no.empty()) tellOnce(fmt::format("{}: left out: {}", way.model.name, no));
    }
  }

  void run(int rounds) { runRounds(trials_, rounds); }

  [[nodiscard]] const std::vector<std::string>& algorithms() const { return algorithms_; }
  [[nodiscard]] const Model& model(std::size_t way) const { return ways_[way].model; }

  /** Of one algorithm over one of the models; its series are added to the table's. None where it refused. */
  std::optional<Figures> take(PaperTable& table, std::size_t way, std::size_t algorithm) const {
    const auto& [model, trajectory, trials] = ways_[way];
    if (trials[algorithm] == nullptr) return {};
    const Trial& trial = *trials[algorithm];
    const Outcome& outcome = trial.outcome();
    PaperCell cell{model.name, model.triangles.size(), trial.algorithm(), {}};
    for (Series& s : describe("", trajectory, outcome, kThreshold)) {
      s.name.erase(0, 1);
      table.series.push_back({fmt::format("{} {} {}", model.name, trial.algorithm(), s.name), s.unit, s.rounds});
      cell.series.push_back(std::move(s));
    }
    table.cells.push_back(std::move(cell));
    std::vector<double> means;
    for (const Timing& t : outcome.rounds) means.push_back(t.mean);
    return Figures{judge(trajectory, outcome.answers, kThreshold).force_mse, estimate(means).median / 1000,
                   estimate(outcome.init_s).median};
  }

  /** Of all over one of the models. */
  std::vector<std::optional<Figures>> takeAll(PaperTable& table, std::size_t way) const {
    std::vector<std::optional<Figures>> all;
    for (std::size_t a = 0; a < algorithms_.size(); ++a) all.push_back(take(table, way, a));
    return all;
  }

 private:
  struct Way {
    Model model;
    Trajectory trajectory;
    std::vector<Trial*> trials;  ///< For each algorithm; null where it refuses.
  };
  Surface surface_;
  std::size_t own_;
  std::vector<std::string> algorithms_;
  std::deque<Way> ways_;
  std::deque<Trial> trials_;
};

const std::vector<std::string> kThree{"ours", "god-object", "nearest"};

std::string number(double x) { return fmt::format("{:.4g}", x); }

std::string number(const std::optional<Figures>& of, double Figures::*which) { return of ? number(*of.*which) : "-"; }

/** Columns "NAME WHAT" for each. */
void addColumns(PaperTable& table, const std::vector<std::string>& names, const char* what) {
  for (const std::string& name : names) table.columns.push_back(name + " " + what);
}

void addCells(std::vector<std::string>& row, const std::vector<std::optional<Figures>>& all, double Figures::*which) {
  for (const std::optional<Figures>& one : all) row.push_back(number(one, which));
}

/** What the thesis prints in table 4.1, all its digits: mean square error, and its seconds in microseconds. */
constexpr struct {
  const char* mse;
  const char* time_us;
} kThesisSpheres[] = {{"0.5018370", "17.320"},
                      {"0.1140975", "21.231"},
                      {"0.0577005", "20.952"},
                      {"0.0297466", "21.790"},
                      {"0.0165954", "22.349"}};

PaperTable sphereTable(double radius, double stiffness, bool thesis, int rounds, const std::vector<std::string>& more) {
  PaperTable table;
  table.title = fmt::format("Table 4.1: spheres of {} mm at {} N/m", radius * 1000, stiffness);
  table.settings = fmt::format(
      "1 N, spiral of 20 turns in 10 s at 1 kHz, no friction, no shading; thesis: a proxy on spheres of 1 mm, its "
      "force and "
      "stiffness not given");
  const Surface surface{stiffness, 0, 0, 0};
  Cells cells(surface, kThree, more);
  table.columns = {"triangles", "thesis MSE", "thesis us"};
  addColumns(table, cells.algorithms(), "MSE");
  table.columns.push_back("ours/nearest");
  addColumns(table, cells.algorithms(), "us");
  for (int i = 0; i < 5; ++i) {
    const Model model = makeModel(fmt::format("sphere:radius={},stacks={}", radius, 4 << i));
    cells.add(model, makeTrajectory("spiral:turns=20", model, surface));
  }
  tellTime(table.title);
  cells.run(rounds);
  for (std::size_t i = 0; i < 5; ++i) {
    const Model& model = cells.model(i);
    const std::vector<std::optional<Figures>> all = cells.takeAll(table, i);
    const double part = all[0]->mse / all[2]->mse;
    std::vector<std::string> row{fmt::format("{}", model.triangles.size()), thesis ? kThesisSpheres[i].mse : "-",
                                 thesis ? kThesisSpheres[i].time_us : "-"};
    addCells(row, all, &Figures::mse);
    row.push_back(fmt::format("{:.3f}", part));
    addCells(row, all, &Figures::mean_us);
    table.rows.push_back(std::move(row));
    table.series.push_back({model.name + " ours/nearest MSE", "", {part}});
  }
  for (Series& s : table.series) s.name = fmt::format("k={} ", stiffness) + s.name;
  return table;
}

PaperTable planeTable(int rounds, const std::vector<std::string>& more) {
  PaperTable table;
  table.title = "Table 4.2: a plane touched with a probe";
  table.settings =
      "1000 N/m; synthetic recording: 1 N on a Lissajous figure, 5 kHz force with 0.02 N of noise, 60 Hz pose with 0.2 "
      "mm, "
      "registered to the mesh; thesis: its own scan, not public; its times are seconds, of what it does not say";
  const Surface surface{1000, 0, 0, 0};
  constexpr std::pair<int, const char*> kThesisPlanes[] = {{1, "0.209460"}, {4, "0.201283"}, {10, "0.198253"}};
  Cells cells(surface, kThree, more);
  table.columns = {"triangles", "thesis MSE", "thesis s"};
  addColumns(table, cells.algorithms(), "MSE");
  addColumns(table, cells.algorithms(), "us");
  for (const auto& known : kThesisPlanes) {
    const Model model = makeModel(fmt::format("plane:half=0.05,cells={}", known.first));
    Apparatus apparatus;
    apparatus.load = {Vec3(0.1, -0.05, 0.2), 0.3};
    apparatus.X_OM.p = Vec3(0.003, -0.002, 0.01);
    apparatus.force_noise = 0.02;
    apparatus.pose_noise = 0.0002;
    MeasuredOptions options;
    options.merge.tip_S = apparatus.tip_S;
    options.merge.free_s = 0.95 * apparatus.free_s;
    options.tip_radius = apparatus.tip_radius;
    const Measured measured = onSurface(record(lissajous(model, {10, 5000, 1}), apparatus), options, model);
    cells.add(model, pressInto(measured.out, surface));
  }
  tellTime(table.title);
  cells.run(rounds);
  for (std::size_t i = 0; i < std::size(kThesisPlanes); ++i) {
    const std::vector<std::optional<Figures>> all = cells.takeAll(table, i);
    std::vector<std::string> row{fmt::format("{}", cells.model(i).triangles.size()), "2.885208",
                                 kThesisPlanes[i].second};
    addCells(row, all, &Figures::mse);
    addCells(row, all, &Figures::mean_us);
    table.rows.push_back(std::move(row));
  }
  return table;
}

PaperTable ridgeTable(int rounds, const std::vector<std::string>& more) {
  PaperTable table;
  table.title = "Table 4.3: a ridge (figure 4.6)";
  table.settings =
      "ridge 5 mm high on a plane, 1 N at 1000 N/m, by arc length at 0.02 m/s from x = -30 to 30 mm, 1 kHz; thesis: "
      "one bump, "
      "its angle and stiffness not given";
  table.columns = {"algorithm", "thesis us", "thesis init s", "thesis MSE", "MSE 45",
                   "MSE 60",    "MSE 75",    "MSE 85",        "us at 85",   "init s at 85"};
  const Surface surface{1000, 0, 0, 0};
  const struct {
    const char *algorithm, *time_us, *init_s, *mse;
  } known[] = {{"ours", "-", "-", "-"},
               {"god-object", "8.1", "0", "0.298"},
               {"nearest", "12.3", "0", "0.0417"},
               {"voxel:cells=128", "3.6", "0.270", "0.0949"}};
  Cells cells(surface, {known[0].algorithm, known[1].algorithm, known[2].algorithm, known[3].algorithm}, more);
  constexpr int kDegrees[] = {45, 60, 75, 85};
  for (const int degrees : kDegrees) {
    const Model model = makeModel(fmt::format("ridge:degrees={}", degrees));
    cells.add(model, makeTrajectory("profile", model, surface));
  }
  tellTime(table.title);
  cells.run(rounds);
  std::vector<std::vector<std::optional<Figures>>> all;  // Of each angle.
  for (std::size_t i = 0; i < std::size(kDegrees); ++i) all.push_back(cells.takeAll(table, i));
  for (std::size_t a = 0; a < cells.algorithms().size(); ++a) {
    std::vector<std::string> row{cells.algorithms()[a], "-", "-", "-"};
    if (a < std::size(known)) row = {known[a].algorithm, known[a].time_us, known[a].init_s, known[a].mse};
    for (const auto& one : all) row.push_back(number(one[a], &Figures::mse));
    row.push_back(number(all.back()[a], &Figures::mean_us));
    row.push_back(number(all.back()[a], &Figures::init_s));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::vector<std::string> withMore(std::vector<std::string> own, const std::vector<std::string>& more) {
  for (const std::string& one : more) {
    if (std::find(own.begin(), own.end(), one) == own.end()) own.push_back(one);
  }
  return own;
}

std::vector<PaperTable> paperTables(int rounds, const std::vector<std::string>& more) {
  return {sphereTable(0.001, 2000, true, rounds, more), sphereTable(0.05, 100, false, rounds, more),
          sphereTable(0.05, 1000, false, rounds, more), planeTable(rounds, more), ridgeTable(rounds, more)};
}

}  // namespace haptic_bench
