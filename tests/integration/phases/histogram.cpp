// An algorithm of two phases that comes from outside, as CONTRIBUTING tells how to add one: it counts the
// surfaces that rays from the middle of the scene meet, and shows each surface as bright as it was met often.
// Linked into the three programs, it is there.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "integration/phases/histogram_traits.h"
#include "render/kernel/kernel.h"

namespace tessera::render {
namespace {

using CountsByShape = std::vector<std::uint64_t>;

constexpr std::size_t kRaysPerPart = 4096;
constexpr std::size_t kBatch = 64;

/// Points of the unit square that leave no gaps [Roberts2018].
std::array<double, 2> point_of(std::uint64_t n) {
  const double i = static_cast<double>(n);
  return {std::fmod(0.7548776662466927 * i, 1.0), std::fmod(0.5698402909980532 * i, 1.0)};
}

struct alignas(64) Rays {
  float origin[3][kBatch], x[kBatch] = {}, y[kBatch] = {}, z[kBatch] = {};
  float t[kBatch], u[kBatch], v[kBatch];
  std::int32_t primitive[kBatch], shape[kBatch], instance[kBatch];

  /// All begin in the middle of the scene's vertices.
  explicit Rays(const SceneTables& scene) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float low = 1e30f, high = -1e30f;
      for (const Vertex& vertex : scene.shapes.vertices) {
        low = std::min(low, vertex.position[axis]);
        high = std::max(high, vertex.position[axis]);
      }
      std::fill_n(origin[axis], kBatch, (low + high) / 2);
    }
  }
  /// Evenly over all directions.
  void aim(std::size_t i, std::array<double, 2> at) {
    const double cosine = 2 * at[0] - 1, sine = std::sqrt(1 - cosine * cosine);
    x[i] = static_cast<float>(sine * std::cos(2 * std::numbers::pi * at[1]));
    y[i] = static_cast<float>(sine * std::sin(2 * std::numbers::pi * at[1]));
    z[i] = static_cast<float>(cosine);
  }
  void trace(const IntegratorContext& context, std::size_t n) {
    context.rays.nearest({origin[0], origin[1], origin[2], x, y, z}, static_cast<int>(n), false,
                         {t, u, v, primitive, shape, instance});
    context.stats.camera_rays += n;
  }
};

std::string blob_of(const CountsByShape& counts) {
  return {reinterpret_cast<const char*>(counts.data()), counts.size() * sizeof(counts[0])};
}

/// False where they are not of so many shapes.
bool add(std::string_view blob, CountsByShape& counts) {
  if (blob.size() != counts.size() * sizeof(counts[0])) return false;
  CountsByShape more(counts.size());
  std::memcpy(more.data(), blob.data(), blob.size());
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += more[i];
  return true;
}

struct Histogram final : Prepared {
  CountsByShape counts;
  double total = 0;
};

bool count_hits(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                std::string& blob) {
  // The second phase reads what the first has made: it counts only what that has seen.
  const auto* const before = static_cast<const Histogram*>(part.prepared);
  CountsByShape counts(context.scene.shapes.shapes.size());
  Rays rays(context.scene);
  for (std::size_t first = 0; first < kRaysPerPart; first += kBatch) {
    if (stop.stop_requested()) return false;
    for (std::size_t i = 0; i < kBatch; ++i) rays.aim(i, point_of(part.part * kRaysPerPart + first + i));
    rays.trace(context, kBatch);
    for (std::size_t i = 0; i < kBatch; ++i) {
      const auto shape = static_cast<std::size_t>(rays.shape[i]);
      if (rays.shape[i] >= 0 && (before == nullptr || before->counts[shape] > 0)) ++counts[shape];
    }
  }
  blob = blob_of(counts);
  return true;
}

bool merge(std::span<const std::string_view> blobs, std::string& merged) {
  CountsByShape sum(blobs.front().size() / sizeof(CountsByShape::value_type));
  for (const std::string_view blob : blobs) {
    if (!add(blob, sum)) return false;
  }
  merged = blob_of(sum);
  return true;
}

std::unique_ptr<const Prepared> prepare(const SceneTables& scene, std::span<const std::string_view> blobs) {
  auto histogram = std::make_unique<Histogram>();
  histogram->counts.resize(scene.shapes.shapes.size());
  if (!add(blobs.back(), histogram->counts)) return nullptr;
  for (const std::uint64_t count : histogram->counts) histogram->total += static_cast<double>(count);
  return histogram;
}

class ShowHistogram final : public Integrator {
 public:
  explicit ShowHistogram(const IntegratorContext& context)
      : context_(context), histogram_(*static_cast<const Histogram*>(context.prepared)) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override {
    std::array<SampleName, kBatch> names;
    Rays rays(context_.scene);
    while (const std::size_t n = work.next(names)) {
      if (stop.stop_requested()) return false;
      for (std::size_t i = 0; i < n; ++i) {
        const auto jitter = point_of(names[i].index);
        rays.aim(i, {(names[i].y + jitter[0]) / context_.scene.sensor.height,
                     (names[i].x + jitter[1]) / context_.scene.sensor.width});
      }
      rays.trace(context_, n);
      std::array<float, 4 * kBatch> planes{};  // R, G, B, A
      for (std::size_t i = 0; i < n; ++i) {
        if (rays.shape[i] < 0) continue;
        const auto met = static_cast<double>(histogram_.counts[static_cast<std::size_t>(rays.shape[i])]);
        for (std::size_t c = 0; c < 3; ++c)
          planes[c * kBatch + i] = static_cast<float>(met / histogram_.total);
        planes[3 * kBatch + i] = 1;
      }
      film.add(std::span(names).first(n), planes.data(), kBatch);
      context_.stats.samples += n;
    }
    return true;
  }

 private:
  const IntegratorContext context_;
  const Histogram& histogram_;
};

constexpr std::array kPhases{AlgorithmPhase{count_hits, merge}, AlgorithmPhase{count_hits, merge}};

// Before main.
[[maybe_unused]] const bool added = [] {
  add_algorithm({.name = integration::kHistogram,
                 .make = [](const IntegratorContext& context) -> std::unique_ptr<Integrator> {
                   return std::make_unique<ShowHistogram>(context);
                 },
                 .phases = kPhases,
                 .prepare = prepare});
  return true;
}();

}  // namespace
}  // namespace tessera::render
