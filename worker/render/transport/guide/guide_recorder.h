// Records of what paths found in the directions in which they went on, for those that come after them.
#pragma once

#include <cstdint>
#include <vector>

#include "render/transport/guide/guide_steering.h"
#include "render/transport/guide/guide_sums.h"

namespace tessera::render::TESSERA_ISA {

class GuideRecorder final : public PathObserver {
 public:
  /// Values are times `exposure`, which makes them about 1. At most `most` sums are made. `guide` is what
  /// steers the paths, and may be null.
  GuideRecorder(float exposure, std::size_t most, const SampleBatch& batch, const GuideSteering* guide)
      : exposure_(exposure), batch_(batch), guide_(guide), sums_(most) {}

  void begun(const PathState&, const HitState&, int) override { events_.clear(); }
  void ended(const Encounter& e, const Scattering& s) override;
  /// All light that comes from now on to the paths that are left comes along their new directions.
  void all_lit(int depth, const PathState& paths, int n) override;
  /// All paths have ended.
  void add_up();

  std::vector<GuideSum> sums() const { return sums_.sorted(); }

 private:
  struct Event {
    std::uint64_t cell;
    std::int32_t slot, bin;
    float throughput;  // sum of its components
    float found;       // light of the sample before, likewise; negative: the path ended here
    // Factors of the square of a value (guide_key::kSquares); negative: not known
    float squares[guide_key::kSquareSums];
  };

  const float exposure_;
  const SampleBatch& batch_;
  const GuideSteering* const guide_;
  GuideSums sums_;
  std::vector<Event> events_;
  std::int32_t latest_[kPadded] = {};  // event of each sample's path, and one more; 0: none
};

}  // namespace tessera::render::TESSERA_ISA
