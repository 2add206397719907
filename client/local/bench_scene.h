// A scene in a renderer of this process, without a farm around it: what `tessera bench` measures.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "mesh/mesh_file.h"
#include "tessera/v1/job.pb.h"
#include "wire/render_counts.h"
#include "wire/tile_result.h"

namespace tessera::render {
class Prepared;
class SharedContents;
}  // namespace tessera::render

namespace tessera::client {

/// Cost of rendering; counts and times of tiles add up.
struct BenchCost {
  double cpu_seconds = 0;
  wire::RenderCounts counts;
  std::map<std::string, double> stage_seconds;  // CPU time by stage (UnitStats.stage_ns)

  BenchCost& operator+=(const BenchCost& other);
};

struct BenchRender {
  std::vector<wire::TileResult> tiles;  // the order is not defined
  BenchCost cost;
};

/// Rays of one kind, traced with no shading at all.
struct BenchRays {
  std::uint64_t count = 0, nodes = 0, primitives = 0;  // rays, and what they visited: not known of Embree
  double cpu_seconds = 0;
};

/// Rendering against tracing the same rays with no shading at all, the two taking turns tile by tile, on one
/// thread.
struct BenchCeiling {
  double render_cpu_seconds = 0, replay_cpu_seconds = 0;
  std::uint64_t rays = 0;
  std::array<BenchRays, 3> by_kind;  // camera, bounce, shadow

  /// Share of the ceiling's rays a second that rendering reaches.
  double share() const { return replay_cpu_seconds / render_cpu_seconds; }
};

/// The results of an algorithm's phases, and what they cost.
struct BenchPhases {
  std::shared_ptr<const render::Prepared> prepared;  // null where there are none
  std::string last;                                  // the blob of the last phase
  BenchCost cost;
};

/// The contents that scenes which are loaded at a time have in common.
std::shared_ptr<render::SharedContents> make_shared_contents();

class BenchScene;

/// A scene with what it shares with others that are loaded while it is there.
struct BuiltScene {
  std::shared_ptr<render::SharedContents> contents;
  std::unique_ptr<BenchScene> scene;
};

class BenchScene {
 public:
  /// Builds the scene of `spec`, whose ISA must be set, out of these blobs. InvalidArgument names what is
  /// wrong with the scene. With `contents`, it shares there what it has in common with others.
  /// Cancelled when `stop` is requested.
  static absl::StatusOr<std::unique_ptr<BenchScene>> load(const v1::JobSpec& spec,
                                                          const std::vector<const SceneBlob*>& blobs,
                                                          int threads,
                                                          render::SharedContents* contents = nullptr,
                                                          std::stop_token stop = {});
  ~BenchScene();

  double build_cpu_seconds() const { return build_cpu_seconds_; }
  /// The structure that rays search: "build_cpu_seconds", "bytes" and, of structures other than Embree's,
  /// "primitives", "nodes", "leaves", "empty_leaves", "references", "depth" and "sah_cost".
  std::map<std::string, double> structure() const;
  /// Warnings of what the scene asked for and was approximated or left out.
  const std::vector<std::string>& warnings() const;
  /// Describes the light of the scene that this integrator would never find; empty where it finds all.
  std::string unseen_light(const std::string& integrator) const;

  /// RenderScene::emitted_flux().
  std::array<double, 3> emitted_flux(std::int32_t rays) const;

  /// Makes all phases of the algorithm on this thread, with the job's seed plus `seed_offset`. Cancelled when
  /// stopped.
  absl::StatusOr<BenchPhases> make_phases(std::uint64_t seed_offset, std::stop_token stop) const;

  /// The light of the surfaces of `scene`, which was loaded for radiosity. Cancelled when stopped.
  absl::StatusOr<LitMesh> radiosity_mesh(const v1::Scene& scene, std::stop_token stop) const;

  /// Renders samples [sample_begin, sample_end) of each pixel of the job on this thread, its seed plus
  /// `seed_offset`. Cancelled when stopped.
  absl::StatusOr<BenchRender> render(std::uint32_t sample_begin, std::uint32_t sample_end,
                                     std::uint64_t seed_offset, std::stop_token stop) const;

  /// Tiles of the job's crop, or passes over the film of integrators that work in passes (then one).
  std::size_t tile_count() const;
  /// Renders samples [sample_begin, sample_end) of each pixel of one tile on this thread, with what
  /// `make_phases` made. Cancelled when stopped.
  absl::StatusOr<BenchRender> render_tile(std::size_t tile, std::uint32_t sample_begin,
                                          std::uint32_t sample_end, const BenchPhases& phases,
                                          std::stop_token stop) const;

  /// Cancelled when stopped.
  absl::StatusOr<BenchCeiling> measure_ceiling(std::uint32_t spp, std::stop_token stop) const;

 private:
  friend class BenchTurns;
  struct Parts;
  explicit BenchScene(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
  double build_cpu_seconds_ = 0;
};

/// Renders one image of every scene, `spp` samples a pixel, with the job's seed plus `seed_offset`, the
/// phases of its algorithm included. The scenes take turns tile by tile (A B B A ...), so that a machine
/// whose speed drifts slows all alike. Cancelled when stopped. One result a scene, in their order.
absl::StatusOr<std::vector<BenchRender>> render_in_turn(std::span<const BenchScene* const> scenes,
                                                        std::uint32_t spp, std::uint64_t seed_offset,
                                                        int threads, std::stop_token stop);

}  // namespace tessera::client
