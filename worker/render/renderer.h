// The renderer as the worker's agent sees it. No gRPC and no protobuf here; scenes are made by
// scene/load_scene.h.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/ray_log.h"
#include "render/accel/structure/figures.h"
#include "render/film/film.h"
#include "render/film/tile_request.h"
#include "wire/tile_result.h"

namespace tessera::render {

/// Kernel ISAs that this machine can run and this build contains, best first: "avx512", "avx2", "neon".
std::vector<std::string> supported_isas();
/// Names the kernel modules that this processor could use and that are not used, for they belong to another
/// build.
std::vector<std::string> refused_kernels();
/// Where there are none: which modules this machine could use, where they were looked for, and what is wrong
/// with them.
std::string why_no_kernels();

/// How this machine rounds with the kernels of each ISA, in the same order: names of
/// proto/wire/arithmetic_class.h. The ISA alone where there are no such kernels.
std::vector<std::string> arithmetic_classes(const std::vector<std::string>& isas);

/// A scene ready to render: geometry, acceleration structure, lights, materials. Immutable, and safe to use
/// from any number of threads at once.
class RenderScene {
 public:
  virtual ~RenderScene() = default;

  /// Renders one tile on the calling thread. Cancelled when `stop` is requested (looked at every few dozen
  /// rays).
  virtual absl::StatusOr<wire::TileResult> render_tile(const TileRequest& tile, std::stop_token stop,
                                                       RenderStats& stats) const = 0;

  /// Reads the blobs of the first phases of the job's algorithm, for units that need them; null where there
  /// are none. InvalidArgument where they are not the phases'. It does not outlive the scene.
  virtual absl::StatusOr<std::shared_ptr<const Prepared>> prepare(
      std::span<const std::string_view> blobs) const = 0;

  /// Makes one part of a phase, as render_tile renders a tile. `crop` are the pixels that the picture has,
  /// for what is made of no others; empty: the film. InvalidArgument where there is no such phase.
  virtual absl::StatusOr<std::string> make_part(const PartRequest& part, const FilmRect& crop,
                                                std::stop_token stop, RenderStats& stats) const = 0;

  /// Merges neighbouring blobs of a phase. InvalidArgument where there is no such phase, or they are not its.
  virtual absl::StatusOr<std::string> merge(std::uint32_t phase,
                                            std::span<const std::string_view> blobs) const = 0;

  /// Renders like render_tile, recording every ray; then measures how fast those rays alone can be traced.
  /// Cancelled when `stop` is requested.
  struct Ceiling {
    /// The same rays, traced with no shading, by their kind.
    struct Rays {
      std::uint64_t count = 0;
      double cpu_seconds = 0;
      RayVisits visits;  // none with Embree
    };
    double render_cpu_seconds = 0;  // time of rendering, without recording
    std::array<Rays, kRayKinds> rays;
    RenderStats stats;
  };
  virtual absl::StatusOr<Ceiling> measure_ceiling(const TileRequest& tile, std::stop_token stop) const = 0;

  /// Figures of the structure that rays are traced through, and the CPU time that it took to build.
  struct Structure {
    StructureFigures figures;
    double build_cpu_seconds = 0;
  };
  virtual Structure structure() const { return {}; }

  /// Things that the scene asks for and that were approximated or left out; one line each.
  virtual const std::vector<std::string>& warnings() const = 0;

  /// Names the light of the scene that the algorithm would never find (scene/light/unseen_light.h); empty
  /// where it finds all.
  virtual std::string unseen_light(const std::string& algorithm) const { return ""; }

  /// R, G and B of the flux that all lights with a place emit when the shutter opens, textures and all, by so
  /// many rays of each, in units of the scene: radiance times its unit of length squared.
  virtual std::array<double, 3> emitted_flux(std::int32_t rays) const { return {}; }

  /// Decisions that building made, and why; one line each.
  virtual std::vector<std::string> notes() const { return {}; }

  /// Names for the indices in StageTimes::materials.
  virtual const std::vector<std::string>& material_names() const = 0;

  /// Bytes held, acceleration structure included.
  virtual std::size_t memory_bytes() const = 0;

  /// Equal for scenes that share these bytes.
  virtual const void* content() const { return this; }
};

}  // namespace tessera::render
