// A short pilot: which of several algorithms renders a job with the least error times time?
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "pilot/candidate.h"
#include "pilot/judge.h"

namespace tessera::client {

/// Renders pictures of candidates.
class PilotRenderer {
 public:
  virtual ~PilotRenderer() = default;
  /// Makes the candidate ready for pictures of this frame; returns the CPU seconds that this took.
  /// InvalidArgument where it cannot render the scene. Not while pictures are rendered.
  virtual absl::StatusOr<double> frame(std::size_t candidate, const PilotFrame& frame) = 0;
  /// Names the light that the candidate would never find; empty where it finds all. Asked once any candidate
  /// is ready.
  virtual std::string unseen_light(std::size_t candidate) const { return ""; }
  /// Renders these samples of each pixel of the frame, with the job's seed plus `seed_offset`. From several
  /// threads at once.
  virtual absl::StatusOr<PilotImage> render(std::size_t candidate, std::uint32_t sample_begin,
                                            std::uint32_t sample_end, std::uint64_t seed_offset) = 0;
  /// CPU seconds that the pilot has taken so far, all of it.
  virtual double spent_seconds() const = 0;
};

/// The share of a job's CPU time that a pilot may take.
inline constexpr double kPilotShare = 0.03;

struct PilotPlan {
  PilotJob job;
  double read_seconds = 0;   // CPU time in which the job's scene was read
  bool keeps_scene = false;  // the job takes over the scene that was built: that is no cost of the pilot
  int threads = 1;
};

/// An algorithm to try, by name and kind.
struct PilotEntry {
  std::string name;
  bool consistent = false;
  int ways = 1;  // PilotCandidate::ways
};

struct PilotOutcome {
  struct Entry {
    Judgement judgement;        // set where there are images
    std::uint32_t images = 0;   // 0: not judged
    std::uint32_t samples = 0;  // samples of an image
    bool dropped = false;       // clearly worse before the end, or refused
    std::string refusal;        // why it cannot render the scene, or is not to
    bool is_blind = false;      // it is left out, since others find light that it never does
  };
  std::vector<Entry> entries;  // one for each candidate, in their order
  std::size_t best = 0;
  bool judged = false;   // false: the time was too short, and the first candidate is taken
  bool is_clear = true;  // the best is ahead of all others by more than three standard errors
  PilotFrame frame;
  double build_seconds = 0;  // CPU time of building scenes
};

/// Tries the candidates, of which the first is the usual one, in at most kPilotShare of what the job would
/// take with the quickest of them. Pictures are as small as that asks for; their samples are spread over the
/// numbers of the job's, since a pass's radius depends on its number, and have seeds of their own. Candidates
/// that are clearly worse are dropped from the sixteenth picture on, and the pilot ends when one is left.
/// Those that never find some of the light are not tried where another candidate finds all of it.
/// Cancelled when stopped; InvalidArgument, that of the first, where no candidate can render the scene.
absl::StatusOr<PilotOutcome> run_pilot(std::span<const PilotEntry> candidates, const PilotPlan& plan,
                                       PilotRenderer& renderer, std::stop_token stop);

}  // namespace tessera::client
