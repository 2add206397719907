// How a job's integrator was chosen, for people and for programs.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// "integrator bdpt, by a pilot of 0.31 CPU s: 4.2 times the efficiency of vcm"; empty where the integrator
/// was named.
std::string choice_text(const v1::JobSpec& spec);

/// A candidate: "vcm: efficiency 812 (2.1 s, variance 5.1e-4, bias^2 6.2e-5)".
std::string candidate_text(const v1::AutoChoice::Candidate& candidate);

/// All of it: the text and those of the candidates, separated by "; ". Empty where the integrator was named.
std::string choice_in_one_line(const v1::JobSpec& spec);

/// {"reason", "pilot_seconds", "build_seconds", "candidates": [{"integrator", "left_out", "images", ...}]};
/// null where the integrator was named.
nlohmann::ordered_json choice_json(const v1::JobSpec& spec);

}  // namespace tessera::client
