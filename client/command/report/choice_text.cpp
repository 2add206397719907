#include "command/report/choice_text.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace tessera::client {

std::string choice_text(const v1::JobSpec& spec) {
  if (!spec.farm().has_auto_choice()) return "";
  const v1::AutoChoice& choice = spec.farm().auto_choice();
  const std::string pilot =
      choice.pilot_seconds() > 0 ? absl::StrFormat(", by a pilot of %.3g CPU s", choice.pilot_seconds()) : "";
  return absl::StrCat("integrator ", spec.content().algorithms().integrator(), pilot, ": ", choice.reason());
}

std::string candidate_text(const v1::AutoChoice::Candidate& candidate) {
  std::string text = candidate.integrator();
  if (candidate.images() > 0) {
    absl::StrAppend(&text,
                    absl::StrFormat(": efficiency %.3g (%.3g CPU s, variance %.2g", candidate.efficiency(),
                                    candidate.cpu_seconds(), candidate.variance()));
    if (candidate.bias2() > 0) absl::StrAppend(&text, absl::StrFormat(", bias^2 %.2g", candidate.bias2()));
    absl::StrAppend(&text, ")");
  }
  if (!candidate.left_out().empty())
    absl::StrAppend(&text, candidate.images() > 0 ? ", " : ": ", candidate.left_out());
  return text;
}

std::string choice_in_one_line(const v1::JobSpec& spec) {
  std::string line = choice_text(spec);
  for (const v1::AutoChoice::Candidate& candidate : spec.farm().auto_choice().candidates())
    absl::StrAppend(&line, "; ", candidate_text(candidate));
  return line;
}

nlohmann::ordered_json choice_json(const v1::JobSpec& spec) {
  if (!spec.farm().has_auto_choice()) return nullptr;
  const v1::AutoChoice& choice = spec.farm().auto_choice();
  nlohmann::ordered_json json;
  json["reason"] = choice.reason();
  json["pilot_seconds"] = choice.pilot_seconds();
  json["build_seconds"] = choice.build_seconds();
  json["width"] = choice.width();
  json["height"] = choice.height();
  json["candidates"] = nlohmann::ordered_json::array();
  for (const v1::AutoChoice::Candidate& candidate : choice.candidates()) {
    nlohmann::ordered_json entry{{"integrator", candidate.integrator()}};
    if (!candidate.left_out().empty()) entry["left_out"] = candidate.left_out();
    if (candidate.images() > 0) {
      entry["images"] = candidate.images();
      entry["samples"] = candidate.samples();
      entry["cpu_seconds"] = candidate.cpu_seconds();
      entry["variance"] = candidate.variance();
      entry["bias2"] = candidate.bias2();
      entry["efficiency"] = candidate.efficiency();
      entry["uncertainty"] = candidate.uncertainty();
      entry["misses_light"] = candidate.misses_light();
    }
    json["candidates"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace tessera::client
