#include "bench/whole.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "image/exr.h"

namespace tessera::client {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kReferenceSeed = 1'000'003;  // measured ones are below a thousand

/// A folder for a picture that goes away with it.
class Scratch {
 public:
  static absl::StatusOr<std::unique_ptr<Scratch>> make() {
    std::error_code error;
    std::string name = (fs::temp_directory_path(error) / "tessera-bench-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      return absl::InternalError(absl::StrCat(name, ": cannot make a temporary folder"));
    return std::unique_ptr<Scratch>(new Scratch(std::move(name)));
  }
  ~Scratch() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  std::string picture() const { return (fs::path(path_) / "picture.exr").string(); }

 private:
  explicit Scratch(std::string path) : path_(std::move(path)) {}
  const std::string path_;
};

struct Picture {
  ProcessCost cost;
  Image image;
};

absl::StatusOr<Picture> render(const WholeSide& side, std::uint32_t spp, std::uint64_t seed,
                               const Scratch& scratch, std::stop_token stop) {
  std::error_code error;
  fs::remove(scratch.picture(), error);
  const absl::StatusOr<std::vector<std::string>> words = side.command(spp, seed, scratch.picture());
  if (!words.ok()) return words.status();
  absl::StatusOr<ProcessCost> cost = run_process(*words, std::move(stop));
  if (!cost.ok())
    return absl::Status(cost.status().code(), absl::StrCat(side.name, ": ", cost.status().message()));
  absl::StatusOr<Image> image = read_exr(scratch.picture());
  if (!image.ok())
    return absl::InternalError(absl::StrCat(side.name, " left no picture: ", image.status().message()));
  return Picture{*cost, *std::move(image)};
}

absl::StatusOr<WholeRun> measure(const WholeSide& side, const CompareOptions& compared, std::uint32_t spp,
                                 std::uint64_t seed, const Scratch& scratch, std::stop_token stop) {
  const absl::StatusOr<Picture> picture = render(side, spp, seed, scratch, std::move(stop));
  if (!picture.ok()) return picture.status();
  const absl::StatusOr<Comparison> errors = compare_images(side.reference->image, picture->image, compared);
  if (!errors.ok())
    return absl::InvalidArgumentError(absl::StrCat(side.name, ": ", errors.status().message()));
  return WholeRun{spp, seed, picture->cost, errors->relmse, errors->relmse_trimmed, errors->relmse_block};
}

std::vector<WholeRun> runs_of(const WholeResult& result, std::uint32_t spp) {
  std::vector<WholeRun> runs;
  for (const WholeRun& run : result.runs) {
    if (run.spp == spp) runs.push_back(run);
  }
  return runs;
}

template <class F>
Interval over(const std::vector<WholeRun>& runs, F property) {
  std::vector<double> values;
  for (const WholeRun& run : runs) values.push_back(property(run));
  return interval_of(values);
}

}  // namespace

absl::StatusOr<std::vector<WholeResult>> measure_whole(
    std::span<const WholeSide> sides, const BenchPlan& plan,
    const std::function<void(const std::string&)>& progress, std::stop_token stop) {
  const absl::StatusOr<std::unique_ptr<Scratch>> scratch = Scratch::make();
  if (!scratch.ok()) return scratch.status();
  std::vector<WholeResult> results;
  for (const WholeSide& side : sides) results.push_back({side.name, side.reference->source, {}});
  for (const std::uint32_t spp : plan.spp) {
    for (std::uint32_t seed = 0; seed < plan.seeds; ++seed) {
      progress(
          absl::StrCat("whole processes, ", spp, " samples a pixel, seed ", seed + 1, " of ", plan.seeds));
      for (std::size_t i = 0; i < sides.size(); ++i) {
        const std::size_t side = seed % 2 == 0 ? i : sides.size() - 1 - i;
        absl::StatusOr<WholeRun> run = measure(sides[side], plan.compared(), spp, seed, **scratch, stop);
        if (!run.ok()) return run.status();
        results[side].runs.push_back(*std::move(run));
      }
    }
  }
  return results;
}

absl::StatusOr<BenchReference> make_reference(const WholeSide& side, std::uint32_t spp,
                                              std::stop_token stop) {
  const absl::StatusOr<std::unique_ptr<Scratch>> scratch = Scratch::make();
  if (!scratch.ok()) return scratch.status();
  absl::StatusOr<Picture> picture = render(side, spp, kReferenceSeed, **scratch, std::move(stop));
  if (!picture.ok()) return picture.status();
  return BenchReference{std::move(picture->image), {}, absl::StrCat("made here, ", spp, " samples a pixel")};
}

Interval whole_ratio(const WholeResult& a, const WholeResult& b, std::uint32_t spp,
                     double (WholeRun::*efficiency)() const) {
  const std::vector<WholeRun> of_a = runs_of(a, spp), of_b = runs_of(b, spp);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(of_a.size(), of_b.size()); ++i)
    ratios.push_back((of_a[i].*efficiency)() / (of_b[i].*efficiency)());
  return interval_of(ratios);
}

std::string to_text(const std::vector<WholeResult>& results) {
  if (results.empty()) return "";
  std::set<std::uint32_t> counts;
  for (const WholeRun& run : results.front().runs) counts.insert(run.spp);
  std::string text = "whole processes, from the command to the file\n";
  for (const WholeResult& result : results) {
    absl::StrAppend(&text, result.name, "; reference: ", result.reference, "\n");
    absl::StrAppendFormat(&text, "  %6s %9s %9s %11s %11s %11s %11s  %s\n", "spp", "CPU s", "wall s",
                          "less 0.1 %", "of means", "efficiency", "of means", "95 % interval");
    for (const std::uint32_t spp : counts) {
      const std::vector<WholeRun> runs = runs_of(result, spp);
      const Interval efficient = over(runs, [](const WholeRun& run) { return run.efficiency(); });
      absl::StrAppendFormat(
          &text, "  %6d %9.3f %9.3f %11.4g %11.4g %11.4g %11.4g  %s\n", spp,
          over(runs, [](const WholeRun& run) { return run.cost.cpu_seconds; }).value,
          over(runs, [](const WholeRun& run) { return run.cost.wall_seconds; }).value,
          over(runs, [](const WholeRun& run) { return run.relmse_trimmed; }).value,
          over(runs, [](const WholeRun& run) { return run.relmse_block; }).value, efficient.value,
          over(runs, [](const WholeRun& run) { return run.block_efficiency(); }).value, ends_of(efficient));
    }
  }
  for (std::size_t i = 1; i < results.size(); ++i) {
    absl::StrAppend(&text, "efficiency of ", results[0].name, " over ", results[i].name, "\n");
    for (const std::uint32_t spp : counts) {
      const Interval ratio = whole_ratio(results[0], results[i], spp);
      const Interval of_means = whole_ratio(results[0], results[i], spp, &WholeRun::block_efficiency);
      absl::StrAppendFormat(&text, "  %6d spp  x %.3f  (95 %%: %s); of means x %.3f  (95 %%: %s)\n", spp,
                            ratio.value, ends_of(ratio), of_means.value, ends_of(of_means));
    }
  }
  return text;
}

}  // namespace tessera::client
