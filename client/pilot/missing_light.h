// Finds candidates whose pictures lack light that another's have.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pilot/candidate.h"

namespace tessera::client {

/// Light that a candidate lacks.
struct MissingLight {
  /// Its share of the relMSE of a picture with the job's samples.
  double error = 0;
  std::string seen_by;  // the candidate that has more light where most is lacking; empty: nothing is lacking
};

/// Compares means over blocks of the picture (all of it, and 4x4 blocks), for all pairs of candidates. No
/// light is negative, so what one candidate sees significantly more of, the other lacks: because it cannot
/// find it, as `light` behind glass, or because it finds it so seldom that no sample of the pilot did, as
/// `path` on caustics, whose variance then looks small. A difference counts where Welch's t-test rejects
/// equality at one in a hundred over all tests (an outlier alone never does: it raises its own standard
/// error). The means of consistent candidates are extrapolated to radius zero: their light is spread over a
/// disk whose area falls with the number of the pass p as (p + 1)^(-1/3) [Knaus and Zwicker 2011]. What they
/// lack themselves is their bias (judge.h).
///
/// The light d that is lacking in a block, where M samples did not find it, is an error of d^2, and as
/// variance of rare samples M d^2 a sample at least: the larger of the two is the error with the job's `spp`.
/// `norms` are the divisors of values as in relMSE (judge.h).
std::vector<MissingLight> find_missing_light(std::span<const PilotCandidate> candidates,
                                             const PilotFrame& frame, std::uint32_t spp,
                                             std::span<const double> norms);

/// How many standard errors more light than `narrow` the candidate `broad`, which finds light in the same
/// ways and in others, has all over the picture: the mean over 4x4 blocks of Welch's t, scaled to a variance
/// of 1 [Stouffer et al. 1949]. Means of skewed samples are below the right one more often than above, so
/// this is less than normal where the broad candidate is the one that varies.
double excess_light(const PilotCandidate& broad, const PilotCandidate& narrow, const PilotFrame& frame,
                    std::span<const double> norms);

}  // namespace tessera::client
