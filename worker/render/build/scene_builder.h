// The steps of load_scene(). Each reads one part of the Scene message and fills the tables; together they
// name every concrete class of the renderer.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/bsdf/tables/balance_table.h"
#include "render/build/load_scene.h"
#include "render/build/motion.h"
#include "render/build/transform.h"
#include "render/color/cie.h"
#include "render/integrator/scene_tables.h"
#include "render/light/light_build.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

class SceneBuilder {
 public:
  /// `arrays` are those of `tables`; rebuild_view() leaves them alone.
  SceneBuilder(const v1::Scene& scene, const v1::JobSpec& job, const BlobSource& blobs, int threads,
               SceneArrays& arrays, SceneTables& tables, std::vector<std::string>& warnings)
      : scene_(scene),
        job_(job),
        blobs_(blobs),
        threads_(threads),
        arrays_(arrays),
        tables_(tables),
        warnings_(warnings) {}

  /// Everything but the acceleration structure and what needs its bounds.
  absl::Status build_tables();
  /// Fills the images that rays may look up, on all threads; the others stay empty. May run beside all that
  /// comes after build_tables().
  absl::Status decode_images();
  /// Camera, film and sampler alone, over the tables of a scene with the same content_key().
  absl::Status rebuild_view();
  /// Whether triangles are to be met by robust tests: as the job says, or as a probe of the tables does.
  /// Warns of what the probe found.
  bool wants_robust_intersection();
  /// Whether rays are to be traced one by one.
  bool wants_single_rays() const { return single_rays_; }
  /// InvalidArgument, naming the instance, where rays from within a sphere of render space leave floats'
  /// range in an instance's own space.
  absl::Status check_instances(const float* centre, float radius) const;
  /// Lights that depend on the scene's size, and the distribution over all lights.
  absl::Status build_light_selection(float scene_radius);

 private:
  // build_settings.cpp
  absl::Status build_settings();

  // build_camera.cpp
  absl::Status build_camera();
  absl::Status set_camera_motion(const Transform& start);
  /// The film's window on the screen; `half_side`: of the screen whose shorter side spans [-1, 1], in camera
  /// space.
  absl::Status set_screen(double half_side);
  absl::Status set_lens(float radius, float focal_distance);
  absl::Status build_filter();

  // build_textures.cpp
  absl::Status build_textures();
  /// The node of a texture that is of use: its images will be decoded.
  absl::StatusOr<int> texture_node(const std::string& name);
  absl::StatusOr<int> named_node(const std::string& name);
  absl::StatusOr<int> add_node(const v1::Texture& texture);
  void need_images(int node);
  absl::StatusOr<int> texture_input(const v1::SpectrumValue& value, const Rgb& otherwise);
  absl::StatusOr<TextureNode> make_node(const v1::Texture& texture);
  absl::StatusOr<TextureNode> image_node(const v1::ImageTexture& image);
  absl::Status set_texture_space(const v1::Matrix& texture_from_world, TextureNode& node);
  absl::Status set_mapping(const v1::UvMapping& mapping, TextureNode& node);
  absl::Status set_noise(const v1::NoiseTexture& noise, TextureNode& node);
  absl::Status set_direction(const v1::Point3& world, TextureNode& node) const;
  /// Replaces a node whose inputs are constants by its value.
  void fold(TextureNode& node) const;
  absl::StatusOr<int> normal_map_node(const v1::ImageTexture& image);
  std::shared_ptr<const TextureImage> image_slot(const v1::ImageTexture& image);

  // build_media.cpp
  absl::Status build_media();
  absl::Status build_medium(const v1::Medium& medium, MediumRecord& record);
  absl::Status set_medium_value(const v1::VolumeValue& value, float otherwise, float scale,
                                MediumValue& result);
  absl::StatusOr<int> density_grid(const v1::VolumeGrid& grid);
  /// To the unit cube that the matrix places.
  absl::StatusOr<Affine> unit_cube_from_render(const v1::Matrix& world_from_cube) const;
  absl::StatusOr<int> medium_index(const std::string& name) const;
  /// Whether paths have to look for media and for surfaces that light passes.
  void decide_volumetric();

  // build_materials.cpp: names, mixes, sides, maps
  absl::Status build_materials();
  absl::Status build_material(const v1::Material& material, MaterialRecord& record);
  absl::Status set_kind(const v1::Material& material, MaterialRecord& record);
  absl::Status set_mix(const v1::MixMaterial& mix, MaterialRecord& record);
  absl::Status set_sides(const v1::Material& material, MaterialRecord& record);
  absl::Status set_maps(const v1::Material& material, MaterialRecord& record);
  absl::Status check_mixes() const;
  absl::StatusOr<int> material_index(const std::string& name) const;

  // build_material_slots.cpp: what several kinds have in common
  absl::Status set_spectrum(const v1::SpectrumValue& value, const Rgb& otherwise, MaterialRecord& record,
                            SpectrumSlot& slot);
  absl::Status set_scalar(const v1::FloatValue& value, float otherwise, MaterialRecord& record,
                          ScalarSlot& slot);
  absl::Status set_tint(const v1::SpectrumValue& value, MaterialRecord& record, SpectrumSlot& slot);
  absl::Status set_roughness(const v1::Roughness& roughness, MaterialRecord& record, ScalarSlot& u,
                             ScalarSlot& v);
  absl::Status set_eta(const v1::Spectrum& eta, float otherwise, MaterialRecord& record);
  /// Whether single precision can work with an index of refraction: from 1e-4 to 1e4.
  static absl::Status check_eta(float eta);
  /// Gives a rough conductor (`eta` 0) or dielectric the table for multiple scattering, unless it asks for
  /// none.
  void set_multiple_scattering(const v1::Roughness& roughness, float eta, MaterialRecord& record);
  ExtendedRecord& extend(MaterialRecord& record);

  // build_material_kinds.cpp: one function a kind
  absl::Status set_conductor(const v1::ConductorMaterial& conductor, MaterialRecord& record);
  absl::Status set_conductor_index(const v1::ConductorMaterial& conductor, MaterialRecord& record);
  absl::Status set_dielectric(const v1::DielectricMaterial& dielectric, MaterialRecord& record);
  absl::Status set_thin_dielectric(const v1::ThinDielectricMaterial& sheet, MaterialRecord& record);
  absl::Status set_coat(const v1::CoatedDiffuseMaterial& coat, const std::string& name,
                        MaterialRecord& record);
  absl::Status set_plastic(const v1::PlasticMaterial& plastic, MaterialRecord& record);
  absl::Status set_coated_conductor(const v1::CoatedConductorMaterial& coated, const std::string& name,
                                    MaterialRecord& record);
  absl::Status set_hair(const v1::HairMaterial& hair, MaterialRecord& record);
  absl::Status set_principled(const v1::PrincipledMaterial& principled, MaterialRecord& record);
  absl::Status set_diffuse_transmission(const v1::DiffuseTransmissionMaterial& material,
                                        MaterialRecord& record);

  // build_shapes.cpp
  absl::Status build_shapes();
  absl::Status build_shape(const v1::Shape& shape, const Transform& placed_from_object, bool instanced,
                           const std::string& where);
  absl::Status add_mesh(const v1::Shape& shape, const Transform& placed_from_object, ShapeRecord& record);
  absl::Status add_quadric(const v1::Shape& shape, const Transform& placed_from_object, ShapeRecord& record);
  absl::Status add_sdf_grid(const v1::Shape& shape, const Transform& placed_from_object, ShapeRecord& record);
  absl::Status add_curves(const v1::Shape& shape, const Transform& placed_from_object, ShapeRecord& record);
  absl::Status add_attributes(const v1::TriangleMesh& mesh, std::int32_t shape);
  absl::Status set_alpha(const v1::Shape& shape, ShapeRecord& record);
  absl::Status set_media(const v1::Shape& shape, ShapeRecord& record);

  // build_instances.cpp: objects, instances, and shapes that move, which are instances of an object each
  struct MovingShape {
    int object;  // in ShapeTable::objects; -1: there is nothing of it to be seen
    Motion motion;
  };
  struct ObjectParts {
    int still =
        -1;  // in ShapeTable::objects: all shapes that do not move within the object; -1: there are none
    std::vector<MovingShape> moving;
    Point anchor;  // instance space; `still` is relative to it
  };
  /// Whether `shape` is placed by a moving instance. Of a lamp, warns that it stands still.
  absl::StatusOr<bool> moves(const v1::Shape& shape, bool instanced, const std::string& where);
  absl::StatusOr<MovingShape> build_moving_shape(const v1::Shape& shape, bool instanced,
                                                 const std::string& where);
  /// `shapes`: indices into those of the scene.
  absl::Status build_moving_shapes(const std::vector<int>& shapes);
  absl::Status build_objects();
  absl::StatusOr<ObjectParts> build_object(const v1::Object& object);
  /// A point among the shapes where they are all far from the origin of instance space, else that origin:
  /// floats hold coordinates about the one as well as those about the other if the author had put it there.
  absl::StatusOr<Point> anchor_of(const v1::Object& object) const;
  absl::Status build_instances();
  absl::Status build_instance(const v1::Instance& instance, const ObjectParts& parts,
                              const std::string& where);
  absl::Status add_instance(int object, int segments,
                            const std::function<Transform(double)>& world_from_instance);

  // build_shading_groups.cpp: after materials, shapes and lights
  void build_shading_groups();

  // build_lights.cpp
  absl::Status build_lights();
  absl::Status add_light(const v1::Light& light, float scale);
  absl::Status add_area_lights(const v1::AreaLight& light, std::int32_t shape);
  absl::Status place_light(const v1::Matrix& matrix, LightRecord& record);
  absl::Status set_light_texture(const std::string& name, LightRecord& record);
  absl::Status set_portal(const v1::InfiniteLight& light, Environment& environment);
  absl::Status add_infinite_light(const v1::InfiniteLight& light, float scale);

  const v1::Scene& scene_;
  const v1::JobSpec& job_;
  const BlobSource& blobs_;
  const int threads_;
  SceneArrays& arrays_;
  SceneTables& tables_;
  std::vector<std::string>& warnings_;

  const wire::AlgorithmTraits* algorithm_ = nullptr;
  bool single_rays_ = false;
  v1::Intersection intersection_ = v1::INTERSECTION_UNSPECIFIED;
  LightSelection light_selection_ = LightSelection::kAuto;
  std::vector<std::string> shape_names_,
      instance_names_;                        // of each of ShapeTable::shapes and instances, for messages
  Point render_origin_;                       // world space
  Transform render_from_world_;               // a translation
  std::map<std::string, int> texture_nodes_;  // by name; kInProgress while it is made
  std::map<std::string, const v1::Texture*> textures_;  // by name
  struct PendingImage {
    const v1::ImageTexture* source;
    std::shared_ptr<TextureImage> image;
    bool needed = false;
  };
  std::map<std::string, PendingImage> images_;  // by digest and encoding
  std::vector<bool> needed_nodes_;              // texture nodes that need_images() has seen
  std::vector<double> node_lookups_;            // of the textures' nodes; beyond the end: 1
  int texture_nesting_ = 0;
  std::map<std::string, int> materials_;        // by name
  std::map<std::string, ObjectParts> objects_;  // by name
  std::map<std::string, int> attributes_;       // of meshes that textures look up, by name
  std::map<std::string, int> media_;            // by name; empty unless the integrator looks for media
  std::map<std::tuple<float, float, int>, int>
      plastic_tables_;  // by index, roughness and kind of microfacets
  std::map<BalancedFacets, int> balance_tables_;
  int default_material_ = 0;
};

/// The point of world space that render space has as its origin: the scene's, else the camera's.
Point render_origin(const v1::Scene& scene, const Transform& world_from_camera);

/// Error for transforms that fits_floats() refuses.
inline constexpr const char* kBeyondFloats =
    "its transform scales by more, or by less, than 32-bit floats hold";

/// "shape 12 (lamp)"
std::string place_in_scene(const char* what, int index, const std::string& name);

/// "shape 12 (lamp): " before the message of a status that is not OK.
absl::Status located(const absl::Status& status, const std::string& where);

/// A spectrum as light, and as matter; white means the same as in color/cie.h.
Rgb emission(const v1::Spectrum& spectrum);
Rgb reflectance(const v1::Spectrum& spectrum);
/// InvalidArgument for numbers that are not finite, and for samples that do not ascend or do not pair up.
absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what);

/// f(0) .. f(n - 1) on up to `threads` threads; the first error that any returned.
absl::Status parallel_for(std::size_t n, int threads, const std::function<absl::Status(std::size_t)>& f);

}  // namespace tessera::render
