// Estimates of what a job would cost and how wrong its picture would be, from a pilot's pictures alone.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pilot/candidate.h"

namespace tessera::client {

/// The job's picture by one candidate, as far as a pilot can tell. Errors are shares of relMSE
/// (image/metrics.h).
struct Judgement {
  double cpu_seconds = 0;
  double variance = 0;
  double bias2 = 0;         // square of what its mean lacks, or blurs
  double uncertainty = 0;   // standard error of the logarithm of the efficiency
  std::string lacks_light;  // the candidate that sees light which this one lacks; empty: none
  /// The candidate with more ways to find light that yet varies more: this one, which cannot be better, has
  /// not met some light so far, and is not to be chosen. Empty: none.
  std::string varies_less_than;
  bool is_doubted = false;  // it varies less than such a candidate, which more pictures may explain

  /// 1 / (relMSE x CPU seconds), as bench has it.
  double efficiency() const;
  /// Whether the candidate may be chosen: what it lacks is in its error, what is not known of it is not.
  bool eligible() const { return varies_less_than.empty(); }
};

/// Judges the candidates, each of which has four pictures or more, by each other: there is no reference.
///
/// The variance is that between pictures. What each pixel is divided by, R^2 + 0.01, comes from the means of
/// all candidates by their precision, over 3x3 pixels, so that an outlier hardly raises its own divisor.
/// Light that a candidate lacks is an error, too (missing_light.h), and such a candidate is no part of those
/// means. The bias of consistent candidates is their difference from the unbiased ones (bench/bias.h), where
/// it stands out from the noise.
///
/// A candidate of independent samples that finds light in more ways, weighted by the balance heuristic, has a
/// variance of no more than one of these ways alone and R^2 [Veach 1997, theorem 9.2], and in practice it
/// hardly varies more at all. If it does, by more than chance does once in a hundred, and either by more than
/// R^2 or with more light all over the picture (excess_light()), then the other's samples have missed light
/// that varies: its variance is no estimate.
///
/// Variance falls as 1 / samples from the pictures' number to the job's.
std::vector<Judgement> judge(std::span<const PilotCandidate> candidates, const PilotFrame& frame,
                             const PilotJob& job);

}  // namespace tessera::client
