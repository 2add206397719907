// What a kernel module exports.
#include <memory>
#include <utility>

#include "render/accel/alpha_filter.h"
#include "render/accel/arithmetic.h"
#include "render/accel/quadric.h"
#include "render/accel/replay.h"
#include "render/accel/sdf.h"
#include "render/integrator/kernel.h"
#include "render/integrator/light/light_tracer.h"
#include "render/integrator/path/wavefront.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace tessera::render::TESSERA_ISA {
namespace {

/// An integrator; its memory, new for every tile, is part of what starting paths costs.
template <class Integrator, class... Args>
std::unique_ptr<Integrator> prepare(RenderStats& stats, Args&&... args) {
  const StageTimer timer(stats.times, Stage::kCamera);
  return std::make_unique<Integrator>(std::forward<Args>(args)...);
}

bool render_path(const SceneTables& scene, const TileRequest& tile, std::stop_token stop, FilmSink& film,
                 RenderStats& stats, RayLog* log) {
  const auto wavefront = prepare<Wavefront>(stats, scene, stats, log, scene.max_depth);
  return wavefront->render(tile, film, stop);
}

bool render_samples(const SceneTables& scene, SampleSource& source, std::uint64_t seed_offset, std::stop_token stop,
                    RenderStats& stats) {
  const auto wavefront = prepare<Wavefront>(stats, scene, stats, nullptr, scene.max_depth);
  return wavefront->render(source, seed_offset, stop);
}

bool render_light(const SceneTables& scene, const TileRequest& tile, std::stop_token stop, FilmSink& film,
                  RenderStats& stats) {
  const auto tracer = prepare<LightTracer>(stats, scene, tile, film, stats);
  return tracer->render(stop);
}

std::uint64_t read_clock() { return clock_ticks(); }

constexpr Kernel kKernel{TESSERA_STRING(TESSERA_ISA),
                         {&intersect_quadric, &occluded_quadric, &intersect_sdf, &occluded_sdf, &filter_alpha},
                         &render_path,
                         &render_samples,
                         &render_light,
                         &replay_rays,
                         &read_clock,
                         &arithmetic_checksum};

}  // namespace
}  // namespace tessera::render::TESSERA_ISA

extern "C" __attribute__((visibility("default"))) const tessera::render::Kernel* tessera_kernel() {
  return &tessera::render::TESSERA_ISA::kKernel;
}
