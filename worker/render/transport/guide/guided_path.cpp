#include "render/transport/guide/guided_path.h"

#include <utility>
#include <vector>

#include "render/film/film_part.h"
#include "render/integrator/algorithm_list.h"
#include "render/transport/guide/guide_field.h"
#include "render/transport/guide/guide_recorder.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Samples of phases are apart from those of the picture, which would be biased if the guide knew them.
constexpr std::uint32_t kFirstStream = 0x67756964;
/// Each phase takes twice the samples of the one before: 1, 2 and 4 parts of this many.
constexpr double kAllShares = 7;

/// Samples of the pixels of a part.
class PartSamples final : public SampleSource {
 public:
  PartSamples(const FilmRect& part, std::uint32_t stream, double samples)
      : samples_(samples),
        stream_(stream),
        x0_(part.x0),
        x1_(part.x1),
        y1_(part.y1),
        x_(part.x0),
        y_(part.y0) {}

  std::size_t next(std::span<SampleName> names) override {
    std::size_t n = 0;
    for (; y_ < y1_ && x0_ < x1_; ++y_, x_ = x0_) {
      for (; x_ < x1_; ++x_) {
        for (; index_ < samples_of_pixel(); ++index_) {
          if (n == names.size()) return n;
          names[n++] = {x_, y_, index_, stream_};
        }
        index_ = 0;
      }
    }
    return n;
  }

 private:
  /// Fractions are pixels with one more, spread evenly [Roberts 2018].
  std::uint32_t samples_of_pixel() const {
    const auto whole = static_cast<std::uint32_t>(samples_);
    const std::uint32_t place = x_ * 0xc13fa9a9u + y_ * 0x91e10da5u;
    return whole + (place * 0x1p-32 < samples_ - whole ? 1 : 0);
  }

  const double samples_;  // a pixel
  const std::uint32_t stream_, x0_, x1_, y1_;
  std::uint32_t x_, y_, index_ = 0;
};

class Learner final : private Wavefront {
 public:
  Learner(const IntegratorContext& context, const GuideField* field) : Wavefront(context) {
    if (field != nullptr) steer(guide_.emplace(scene_, *field, batch_));
    add(records_.emplace(scene_.sensor.response.exposure, wire::kMostGuideSums, batch_,
                         guide_ ? &*guide_ : nullptr));
  }
  bool follow(SampleSource& work, std::stop_token stop) {
    while (batch_.start(work, paths_)) {
      if (stop.stop_requested()) return false;
      trace(0, batch_.size());
      records_->add_up();
    }
    return !stop.stop_requested();
  }
  std::string blob() const { return guide_blob(records_->sums()); }

 private:
  std::optional<GuideSteering> guide_;
  std::optional<GuideRecorder> records_;
};

}  // namespace

GuidedPath::GuidedPath(const IntegratorContext& context) : Wavefront(context) {
  const auto* const field = static_cast<const GuideField*>(context.prepared);
  if (field != nullptr && field->any_followed()) steer(guide_.emplace(scene_, *field, batch_));
}

bool make_guide(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                std::string& blob) {
  const std::uint64_t samples = context.stats.samples;
  const auto learner = std::make_unique<Learner>(context, static_cast<const GuideField*>(part.prepared));
  const SensorRecord& film = context.scene.sensor;
  PartSamples source(film_part(film.width, film.height, part), kFirstStream + part.phase,
                     context.scene.own["samples"] * (1u << part.phase) / kAllShares);
  const bool finished = learner->follow(source, std::move(stop));
  context.stats.samples = samples;  // a phase's samples are none of the picture's
  blob = learner->blob();
  return finished;
}

bool merge_guides(std::span<const std::string_view> blobs, std::string& merged) {
  std::vector<GuideSum> sums;
  for (const std::string_view blob : blobs) {
    if (!append_guide_blob(blob, sums)) return false;
  }
  merged = guide_blob(added_up(std::move(sums)));
  return true;
}

std::unique_ptr<const Prepared> prepare_guide(const SceneTables&, std::span<const std::string_view> blobs) {
  std::vector<GuideSum> sums;
  for (const std::string_view blob : blobs) {
    if (!append_guide_blob(blob, sums)) return nullptr;
  }
  return std::make_unique<GuideField>(added_up(std::move(sums)));
}

constexpr AlgorithmPhase kPhases[] = {
    {&make_guide, &merge_guides}, {&make_guide, &merge_guides}, {&make_guide, &merge_guides}};
const ListedAlgorithm guided{{"guided", &make<GuidedPath>, kPhases, &prepare_guide}};

}  // namespace tessera::render::TESSERA_ISA
