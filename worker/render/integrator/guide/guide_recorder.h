// Records of what paths found in the directions in which they went on, for those that come after them.
#pragma once

#include <cstdint>
#include <vector>

#include "render/integrator/guide/guided_event.h"
#include "render/integrator/vertex/sample_batch.h"

namespace tessera::render::TESSERA_ISA {

class GuideRecorder {
 public:
  /// Values are times `exposure`, which makes them about 1. At most `most` sums are made.
  GuideRecorder(float exposure, std::size_t most) : exposure_(exposure), sums_(most) {}

  /// A batch begins.
  void begin() { events_.clear(); }
  /// 16 paths go on, those of `alive`; in `learnt` of them the direction is to be known. `before` is their
  /// throughput before the event.
  void add(const GuideField* field, const Guided& guided, const GuideCells& cells, const GuidedSample& sample,
           Spectrum before, Int slot, Mask learnt, Mask alive);
  /// All light that comes from now on to the paths that are left comes along their new directions.
  void all_found(const SampleBatch& batch, const PathState& paths, int n);
  /// The paths have ended.
  void end(const SampleBatch& batch);

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
  GuideSums sums_;
  std::vector<Event> events_;
  std::int32_t latest_[kPadded] = {};  // event of each sample's path, and one more; 0: none
};

}  // namespace tessera::render::TESSERA_ISA
