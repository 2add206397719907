#include "command/report/time_spent.h"

#include <algorithm>
#include <initializer_list>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace tessera::client {
namespace {

using Times = google::protobuf::Map<std::string, google::protobuf::uint64>;

double seconds_of(const Times& times, const std::string& name) {
  const auto found = times.find(name);
  return found == times.end() ? 0 : 1e-9 * static_cast<double>(found->second);
}

double total(const std::vector<TimePart>& parts) {
  double sum = 0;
  for (const TimePart& part : parts) sum += part.seconds;
  return sum;
}

/// The largest first, scaled so that they add up to `seconds`.
std::vector<TimePart> shares_of(const Times& times, double seconds) {
  std::vector<TimePart> parts;
  for (const auto& [name, nanoseconds] : times) parts.push_back({name, static_cast<double>(nanoseconds)});
  const double sum = total(parts);
  if (!(sum > 0)) return {};
  for (TimePart& part : parts) part.seconds *= seconds / sum;
  std::ranges::sort(parts, [](const TimePart& a, const TimePart& b) {
    return a.seconds != b.seconds ? a.seconds > b.seconds : a.name < b.name;
  });
  return parts;
}

/// "import 4 %, build 10 %": those that can be seen, at most `most` of them.
std::string list_of(const std::vector<TimePart>& parts, double whole, std::size_t most) {
  std::vector<std::string> words;
  for (const TimePart& part : parts) {
    const double percent = 100 * part.seconds / whole;
    if (percent >= 0.5 && words.size() < most)
      words.push_back(absl::StrFormat("%s %.0f %%", part.name, percent));
  }
  return absl::StrJoin(words, ", ");
}

}  // namespace

TimeSpent time_spent(const v1::UnitStats& stats, const std::optional<ProcessTime>& process) {
  TimeSpent spent;
  const auto add = [&](const std::string& name, double seconds) {
    spent.stages.push_back({name, std::max(seconds, 0.0)});
  };
  const auto add_stages = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) add(name, seconds_of(stats.stage_ns(), name));
  };
  if (process) add("start", process->start_seconds);
  if (process) add("import", process->import_seconds);
  if (process && process->pilot_seconds > 0) add("pilot", process->pilot_seconds);
  add_stages({"fetch", "build"});
  const double loading = total(spent.stages);
  add_stages(
      {"camera", "intersection", "transit", "shading", "photon map", "gather", "shadow", "film", "encode"});
  const double units = static_cast<double>(stats.cpu_time().seconds()) + 1e-9 * stats.cpu_time().nanos();
  add("other", units - (total(spent.stages) - loading));
  if (process) add("coordination", process->total_seconds - loading - units);
  spent.seconds = total(spent.stages);

  const double shading = seconds_of(stats.stage_ns(), "shading");
  spent.shading = shares_of(stats.shading_part_ns(), shading);
  const auto materials = std::ranges::find(spent.shading, "materials", &TimePart::name);
  if (materials != spent.shading.end()) spent.materials = shares_of(stats.material_ns(), materials->seconds);
  return spent;
}

std::string to_text(const TimeSpent& spent) {
  if (!(spent.seconds > 0)) return "";
  constexpr std::size_t kMostMaterials = 6;
  std::vector<std::string> words;
  for (const TimePart& stage : spent.stages) {
    std::string word = list_of({stage}, spent.seconds, 1);
    if (word.empty()) continue;
    const std::string parts = stage.name == "shading" ? list_of(spent.shading, spent.seconds, 4) : "";
    words.push_back(parts.empty() ? word : absl::StrCat(word, " (", parts, ")"));
  }
  std::string text = absl::StrFormat("%.4g CPU s: %s", spent.seconds, absl::StrJoin(words, ", "));
  const std::string materials = list_of(spent.materials, spent.seconds, kMostMaterials);
  if (!materials.empty()) absl::StrAppend(&text, "\nmaterials: ", materials);
  return text;
}

}  // namespace tessera::client
