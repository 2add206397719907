// Lights of a scene's messages -> LightTable.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "photometry/lamps/luminaire.h"
#include "photometry/sky/sky.h"
#include "render/light/light_build.h"
#include "render/light/light_table.h"
#include "render/light/moving_lights.h"
#include "render/scene/blob_source.h"
#include "render/scene/light/light_amount.h"
#include "render/scene/light/moving_light.h"
#include "render/scene/placement/motion.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/shape/emitter.h"
#include "render/scene/spectral/spectral_builder.h"
#include "render/scene/texture/texture_nodes.h"
#include "render/scene/values/fault_list.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"
#include "tessera/v1/settings.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

struct LightInputs {
  const RenderSpace& space;
  const BlobSource& blobs;  // source of environment maps
  const wire::AlgorithmTraits& algorithm;
  TextureNodes& textures;
  /// Reads only the headers of environment maps, which stay black: for scenes that are not rendered.
  bool headers_alone = false;
  SpectralBuilder* spectral = nullptr;           // jobs of wavelengths only
  std::vector<std::string>* warnings = nullptr;  // null: nobody is warned
  SceneScale scale = {};                         // of the scene's units
};

class LightBuilder {
 public:
  using Lights = google::protobuf::RepeatedPtrField<v1::Light>;

  LightBuilder(const LightInputs& inputs, LightTable& table) : inputs_(inputs), table_(table) {}

  /// The lights of shapes, and those shapes' references to them. InvalidArgument names the shape.
  absl::Status add_area_lights(const std::vector<Emitter>& emitters, ShapeTable& shapes);
  /// All other lights. InvalidArgument names the light.
  absl::Status add_lights(const Lights& lights);
  /// The same, but goes on after a fault, until the list is full.
  void add_lights(const Lights& lights, FaultList& faults);
  /// Makes lights as bright as their amounts say whose textures count for that, once images are decoded.
  /// InvalidArgument names the light or the shape.
  absl::Status settle_amounts();
  /// SpectralTables::curve_of_light, once all lights are there.
  std::vector<std::int32_t> curves_by_light() const;
  /// Errors of add_area_lights(), but for the name of the shape.
  absl::Status check_area_light(const v1::AreaLight& light);

 private:
  /// That of a shape, whatever its kind.
  absl::StatusOr<LightRecord> read_area_light(const v1::AreaLight& light);
  /// `instance`: what places the shape; -1: it stands in the world.
  absl::Status add_area_light(const Emitter& emitter, std::int32_t instance, ShapeTable& shapes);
  absl::Status add_light(const v1::Light& light);
  /// `way`: from its own space to the world, if it moves.
  absl::Status set_kind(const v1::Light& light, float scale, LightRecord& record, LightWay& way);
  absl::Status set_goniometric(const v1::GoniometricLight& light, const MotionKeys& keys, float scale,
                               LightRecord& record, LightWay& way);
  absl::Status set_spot(const v1::SpotLight& spot, LightRecord& record);
  absl::Status set_projection(const v1::ProjectionLight& projection, LightRecord& record);
  /// Where a light with a rotation stands.
  template <class Message>
  absl::Status place(const Message& light, const MotionKeys& keys, LightRecord& record, LightWay& way) const;
  absl::Status set_texture(const std::string& name, LightRecord& record);
  absl::Status set_color(const v1::Spectrum& spectrum, float scale, const char* what, LightRecord& record);
  /// The lights that were added since are those of the latest set_color().
  void note_curve();
  /// Warns where the latest light is not where its keys have it.
  void warn_of_roughness(const std::string& place);
  /// Warns where nothing has the colour of the latest set_color().
  void warn_of_color(const std::string& place);

  // amounts_of_lights.cpp
  /// A luminaire as its file has it, and its map, which lights that name the same file share.
  struct FileLight {
    photometry::Luminaire luminaire;
    double mean_candelas = 0;
    int texture = -1;
  };
  absl::StatusOr<const FileLight*> file_light(const v1::BlobRef& file);
  /// Gives `record` the directions of a photometric file.
  absl::Status set_photometric_file(const v1::GoniometricLight& light, LightRecord& record);
  /// The amount of a light, by its message or its file; nothing where its spectrum says how bright it is.
  absl::StatusOr<std::optional<Amount>> amount_of(const v1::Light& light);
  /// Makes the lights from `first` on, which are those of `light`, as bright as their amount says.
  absl::Status set_amount(const v1::Light& light, const LightRecord& record, std::size_t first);
  absl::Status set_amount(const v1::AreaLight& light, bool moves, std::size_t first);
  /// The factor that records of the latest set_color() need for an amount of 1 in base units of this
  /// quantity, were they all of it; per m^2 where that is so.
  absl::StatusOr<double> brightness_of(const Amount& amount);
  /// InvalidArgument where floats do not hold what comes of it.
  absl::Status scale_lights(std::size_t first, std::size_t last, double factor);
  /// Faults where the lights from `first` on are no plane figure of one normal.
  absl::Status check_flat(std::size_t first) const;

  // moving_light.cpp
  /// The tables of lights that move, which have room for all lights so far.
  MovingLights& moving();
  /// `record` stands in render space, but has its directions in its own.
  absl::Status add_moving_light(const LightWay& way, LightRecord record);
  /// The lights of a shape that an instance places; `light` has what they share.
  void add_moving_area_light(const Emitter& emitter, const LightRecord& light, const InstanceRecord& place,
                             ShapeTable& shapes);
  void add_moving_records(LightMotion motion, std::vector<LightRecord> own);

  // infinite_light.cpp
  absl::Status add_infinite(const v1::Light& light, float scale);
  /// `mean`: that of the map's luminance over all directions, instead of its own times `scale`.
  absl::StatusOr<Environment> environment_of(const v1::InfiniteLight& light, float scale,
                                             std::optional<double> mean) const;
  absl::Status set_portal(const v1::InfiniteLight& light, Environment& environment) const;

  // sky_light.cpp
  /// A sky with its ground, and a record for its sun behind it.
  absl::Status add_sky(const v1::Light& light, float scale);
  absl::Status add_sun(const v1::SkyLight& light, const photometry::Sky& sky, float scale);
  absl::Status add_map(TextureImage image, EnvironmentMapping mapping, float scale,
                       const Affine& world_from_light);
  /// A colour with a luminance of 1, and `latest_` as of set_color().
  absl::StatusOr<spectra::Rgb> color_of_sky(bool is_said, const v1::Spectrum& spectrum, const char* field);

  const LightInputs inputs_;
  LightTable& table_;
  std::shared_ptr<MovingLights> moving_;  // that of the table
  SpectralEmission latest_;               // of the latest set_color()
  std::string roughness_;                 // how far steps of the latest light leave its way
  /// Lights whose whole light is known once images are decoded.
  struct PendingAmount {
    std::string where;
    std::size_t first = 0, last = 0;
    double brightness =
        0;  // wanted: radiance or intensity times area or solid angle, of colours with luminance 1
    double luminance = 0;  // of their colour
    bool textured = false;
  };
  std::vector<PendingAmount> pending_amounts_;
  std::map<std::string, FileLight> file_lights_;  // by digest
  bool warned_of_metres_ = false;
  std::string place_;  // of the light that is added, for messages
  std::vector<std::int32_t> curves_;
};

/// Builds what lights are chosen by, as a job asks, of a scene within a sphere of render space, once all
/// lights are there.
void build_light_selection(const v1::Algorithms& asked, const float* centre, float radius, LightTable& table);

}  // namespace tessera::render
