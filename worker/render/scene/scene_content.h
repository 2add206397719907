// All of a scene that does not depend on how it is looked at.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/ray_query.h"
#include "render/accel/ray_structure.h"
#include "render/integrator/scene_tables.h"
#include "render/scene/load_scene.h"

namespace tessera::v1 {
class Shape;
}

namespace tessera::render {

struct AccelKernel;

/// `tables` has the view of the job that it was built for.
struct SceneContent {
  SceneArrays arrays;
  SceneTables tables{arrays};
  std::vector<std::string> warnings, notes, material_names;
  std::vector<std::int32_t> shape_numbers;    // numbers of the messages of arrays.shapes (view/layers.h)
  std::unique_ptr<RayStructure> accelerator;  // reads the arrays: goes first
  std::unique_ptr<RayQuery> rays;             // asks it
  double accelerator_cpu_seconds = 0;         // CPU time of building it
};

/// Key of the content: jobs that share it differ only in what view_content() sets. Positions are relative to
/// the origin of render space, so that stays; settings that are not named in it are taken to matter.
std::string content_key(const v1::Scene& scene, const v1::JobSpec& job, const std::string& isa);

/// Sets camera, film and sampler in the tables of content that has the key of this scene and job.
absl::Status view_content(const v1::Scene& scene, const v1::JobSpec& job, const BlobSource& blobs,
                          SceneTables& tables);

/// Builds content in two steps. Errors as of load_scene(). The arguments must outlive it.
class ContentBuild {
 public:
  /// Turns the scene's messages into arrays.
  static absl::StatusOr<ContentBuild> begin(const v1::Scene& scene, const v1::JobSpec& job,
                                            const BlobSource& blobs, const LoadOptions& options,
                                            const AccelKernel& accel, LightSources light_sources);
  ContentBuild(ContentBuild&&) noexcept;
  ~ContentBuild();

  /// May be changed before finish(), which asks the kinds that the records then have.
  SceneArrays& arrays();
  /// The arrays' shapes, which live on without this object, for those that do not finish().
  std::shared_ptr<const ShapeTable> shapes() const;
  /// The message of each of them: in `scene`.
  const std::vector<const v1::Shape*>& shape_messages() const;
  const std::vector<std::string>& warnings() const;
  /// Builds all that follows from the arrays: the BVH, how lights are chosen, what paths have to look for.
  /// Not called twice.
  absl::StatusOr<std::shared_ptr<const SceneContent>> finish();

 private:
  struct Parts;
  explicit ContentBuild(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace tessera::render
