#include "render/transport/guide/guide_recorder.h"

#include <algorithm>
#include <bit>

namespace tessera::render::TESSERA_ISA {

namespace {

TESSERA_INLINE Float sum_of(Spectrum s) {
  Float sum(0.0f);
  for (int c = 0; c < kSpectrumLanes; ++c) sum = sum + s.c[c];
  return sum;
}

float light_of(const SampleBatch& batch, int slot) {
  return sum_of(batch.radiance(slot & ~(kWidth - 1))).lane(slot & (kWidth - 1));
}

}  // namespace

void GuideRecorder::ended(const Encounter& e, const Scattering& scattering) {
  alignas(64) std::int32_t slots[kWidth];
  e.path.slot.store(slots);
  const std::uint32_t alive = scattering.alive.bits();
  for (std::uint32_t bits = alive; bits != 0; bits &= bits - 1) latest_[slots[std::countr_zero(bits)]] = 0;
  const BsdfSample& s = scattering.bsdf;
  const Mask learnt = guidable(e.vertex, scattering.lanes) & s.valid;
  if (none(learnt)) return;

  const GuideCells cells = guide_ != nullptr ? guide_->cells() : guide_cells_at(e, batch_);
  const Float throughput = sum_of(e.path.beta);
  const Int bin = guide_bin(s.wi);
  // Another density in the place of the one that was sampled changes a sample's square by their ratio.
  Float squares[guide_key::kSquareSums] = {Float(-1.0f), Float(-1.0f)};
  if (guide_ != nullptr) {
    if (const Mask known = learnt & guide_->guided().known; any(known)) {
      constexpr float kMost = 256;
      const Float bsdf_pdf = guide_->bsdf_pdf();
      const Float mixed =
          fma(kGuideFraction, guide_->field().pdf(guide_->guided(), s.wi, known) - bsdf_pdf, bsdf_pdf);
      squares[0] = select(known, min(s.pdf / bsdf_pdf, kMost), -1.0f);
      squares[1] = select(known, min(s.pdf / mixed, kMost), -1.0f);
    }
  }
  for (std::uint32_t bits = learnt.bits(); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    Event event{guide_key::cell(cells.size_exponent.lane(i), cells.x.lane(i), cells.y.lane(i),
                                cells.z.lane(i), cells.side.lane(i)),
                slots[i],
                bin.lane(i),
                throughput.lane(i),
                -1,
                {}};
    for (int k = 0; k < guide_key::kSquareSums; ++k) event.squares[k] = squares[k].lane(i);
    events_.push_back(event);
    if ((alive >> i & 1) != 0) latest_[slots[i]] = static_cast<std::int32_t>(events_.size());
  }
}

void GuideRecorder::all_lit(int, const PathState& paths, int n) {
  for (int i = 0; i < n; ++i) {
    const std::int32_t slot = paths.slot[i];
    if (latest_[slot] == 0) continue;
    events_[static_cast<std::size_t>(latest_[slot] - 1)].found = light_of(batch_, slot);
    latest_[slot] = 0;
  }
}

void GuideRecorder::add_up() {
  for (const Event& event : events_) {
    double value = 0;
    if (event.found >= 0 && event.throughput > 0) {
      const double light = double{light_of(batch_, event.slot)} - double{event.found};
      value = std::max(light, 0.0) / double{event.throughput} * double{exposure_};
    }
    sums_.add(guide_key::with_bin(event.cell, static_cast<std::uint64_t>(event.bin)), guide_value(value));
    if (event.squares[0] < 0 || !(value > 0)) continue;
    for (int k = 0; k < guide_key::kSquareSums; ++k) {
      sums_.add(guide_key::with_bin(event.cell, guide_key::kSquares + static_cast<std::uint64_t>(k)),
                guide_value(value * value * double{event.squares[k]}));
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
