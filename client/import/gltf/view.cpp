#include "import/gltf/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::client::gltf {

std::optional<Imath::M44d> without_scale(Imath::M44d t) {
  for (int r = 0; r < 3; ++r) {
    const double norm = length({t[r][0], t[r][1], t[r][2]});
    if (!(norm > 0)) return std::nullopt;
    for (int c = 0; c < 3; ++c) t[r][c] /= norm;
  }
  if (!inverse(t)) return std::nullopt;
  return t;
}

namespace {

constexpr std::uint32_t kFilmWidth = 1280, kFilmHeight = 720;
constexpr double kDegrees = 180 / std::numbers::pi;
/// The factor by which Blender's exporter multiplies the watts of lamps by (PBR_WATTS_TO_LUMENS); for suns it
/// does not.
constexpr double kBlenderLumensPerWatt = 683;

void set_film(Context& context, double aspect) {
  v1::Film& film = *context.scene.mutable_film();
  const double width = std::clamp(aspect, 1.0 / 16, 16.0) * kFilmHeight;
  film.set_width(static_cast<std::uint32_t>(std::lround(width)));
  film.set_height(kFilmHeight);
}

void write_perspective(Context& context, const Json& camera) {
  const Json* perspective = member(&camera, "perspective");
  const double yfov = number_of(perspective, "yfov", 1), znear = number_of(perspective, "znear", 0),
               zfar = number_of(perspective, "zfar", 0);
  const double aspect = number_of(perspective, "aspectRatio", static_cast<double>(kFilmWidth) / kFilmHeight);
  set_film(context, aspect);
  // Ours is across the shorter side.
  const double shorter = 2 * std::atan(std::tan(yfov / 2) * std::min(aspect, 1.0));
  context.scene.mutable_camera()->mutable_perspective()->set_fov_degrees(
      static_cast<float>(shorter * kDegrees));
  context.scene.mutable_camera()->set_near_clip(static_cast<float>(znear));
  context.scene.mutable_camera()->set_far_clip(static_cast<float>(zfar));
}

void write_orthographic(Context& context, const Json& camera, const std::string& place) {
  const Json* orthographic = member(&camera, "orthographic");
  const double xmag = std::abs(number_of(orthographic, "xmag", 1)),
               ymag = std::abs(number_of(orthographic, "ymag", 1)),
               znear = number_of(orthographic, "znear", 0), zfar = number_of(orthographic, "zfar", 0);
  if (xmag == 0 || ymag == 0) {
    context.error(below(place, "orthographic"), "xmag or ymag is 0");
    return;
  }
  set_film(context, xmag / ymag);
  v1::Camera& message = *context.scene.mutable_camera();
  message.mutable_orthographic();
  for (const double edge : {-xmag, xmag, -ymag, ymag}) message.add_screen_window(static_cast<float>(edge));
  message.set_near_clip(static_cast<float>(znear));
  message.set_far_clip(static_cast<float>(zfar));
}

/// A view from the front, above and to the right, of the box about everything.
void write_default_camera(Context& context, const Extent& extent) {
  constexpr double kFov = 40;
  const Imath::V3d center = (extent.low + extent.high) * 0.5;
  const Imath::V3d direction = Imath::V3d(0.45, 0.35, 1).normalized();
  const Imath::V3d right = Imath::V3d(0, 1, 0).cross(direction).normalized(), up = direction.cross(right);
  // So far that each corner of the box is in the picture, with some room about it.
  const double tangent = std::tan(kFov / 2 / kDegrees);
  double distance = 1e-6;
  for (int i = 0; i < 8; ++i) {
    const Imath::V3d corner(i & 1 ? extent.high.x : extent.low.x, i & 2 ? extent.high.y : extent.low.y,
                            i & 4 ? extent.high.z : extent.low.z);
    const Imath::V3d v = corner - center;
    const double across = std::max(std::abs(v.dot(up)), std::abs(v.dot(right)) * kFilmHeight / kFilmWidth);
    distance = std::max(distance, 1.1 * (v.dot(direction) + across / tangent));
  }
  const auto camera_from_world = look_at(center + direction * distance, center, {0, 1, 0});
  v1::Camera& camera = *context.scene.mutable_camera();
  camera.mutable_perspective()->set_fov_degrees(kFov);
  // look_at() is for left-handed worlds: in glTF's, its x points to the left.
  if (camera_from_world)
    write_matrix(scaling(-1, 1, 1) * inverse(*camera_from_world).value_or(Imath::M44d()),
                 *camera.mutable_world_from_camera());
  set_film(context, static_cast<double>(kFilmWidth) / kFilmHeight);
}

/// Finds the camera of the options.
const Node* choose_camera(Context& context, const std::vector<Node>& nodes) {
  const std::string& wanted = context.options.camera;
  const Node* chosen = nullptr;
  std::size_t count = 0;
  for (const Node& node : nodes) {
    const auto camera = index_of(node.json, "camera");
    if (!camera || !node.is_in_scene) continue;
    ++count;
    const bool matches = wanted.empty() || node.name == wanted || concat(*camera) == wanted ||
                         text_of(element(&context.document, "cameras", *camera), "name") == wanted;
    if (matches && chosen == nullptr) chosen = &node;
  }
  if (!wanted.empty() && chosen == nullptr)
    context.error("/cameras", concat("the scene has no camera \"", wanted, "\""));
  if (wanted.empty() && count > 1)
    context.warn(chosen->place, concat("the scene has ", count, " cameras: this one sees it"));
  return chosen;
}

v1::Spectrum light_color(const Json& light, double factor) {
  const Json* color = member(&light, "color");
  v1::Spectrum spectrum;
  const auto component = [&](std::size_t c) {
    return static_cast<float>(factor * (color == nullptr ? 1 : (*color)[c].get<double>()));
  };
  spectrum.mutable_rgb()->set_r(component(0));
  spectrum.mutable_rgb()->set_g(component(1));
  spectrum.mutable_rgb()->set_b(component(2));
  return spectrum;
}

void put(const Imath::V3d& p, v1::Point3& point) {
  point.set_x(p.x);
  point.set_y(p.y);
  point.set_z(p.z);
}

class LightWriter {
 public:
  explicit LightWriter(Context& context) : context_(context) {
    const std::string generator = text_of(member(&context.document, "asset"), "generator");
    from_blender_ = generator.find("glTF Blender I/O") != std::string::npos;
  }

  bool is_from_blender() const { return from_blender_; }

  void write(const Node& node, const Json& light, const std::string& place) {
    const std::string type = text_of(&light, "type");
    const double intensity = number_of(&light, "intensity", 1);
    const Imath::M44d& start = node.world_from_node;
    const Imath::V3d position(start[3][0], start[3][1], start[3][2]);
    const Imath::V3d direction = transformed_vector({0, 0, -1}, start);
    if (!(length(direction) > 0)) {
      context_.warn(node.place, "a light on a node whose scale is 0 is left out");
      return;
    }
    v1::Light& message = *context_.scene.add_lights();
    message.set_name(node.name.empty() ? text_of(&light, "name") : node.name);
    if (type == "directional") {
      put(direction, *message.mutable_distant()->mutable_direction());
      *message.mutable_distant()->mutable_irradiance() = light_color(light, intensity);
      return move(node, message);
    }
    if (from_blender_)
      context_.warn(place, "lamps of Blender's exporter are taken as watts: candela are divided by 683");
    const v1::Spectrum color =
        light_color(light, from_blender_ ? intensity / kBlenderLumensPerWatt : intensity);
    if (type == "point") {
      put(position, *message.mutable_point()->mutable_position());
      *message.mutable_point()->mutable_intensity() = color;
      return move(node, message);
    }
    const Json* spot = member(&light, "spot");
    const double inner = number_of(spot, "innerConeAngle", 0),
                 outer =
                     std::min(number_of(spot, "outerConeAngle", std::numbers::pi / 4), std::numbers::pi / 2);
    if (spot == nullptr || inner >= outer) {
      context_.error(place, spot == nullptr ? "a spot light without \"spot\""
                                            : "innerConeAngle is not below outerConeAngle");
      return;
    }
    v1::SpotLight& result = *message.mutable_spot();
    put(position, *result.mutable_position());
    put(position + direction * (1 / length(direction)), *result.mutable_target());
    *result.mutable_intensity() = color;
    result.set_cone_angle_degrees(static_cast<float>(outer * kDegrees));
    result.set_cone_delta_degrees(static_cast<float>((outer - inner) * kDegrees));
    move(node, message);
  }

 private:
  void move(const Node& node, v1::Light& light) {
    if (node.motion.size() > 1 && !write_light_motion(node.motion, light))
      context_.warn(node.place, "a light on a node whose scale becomes 0 stands still");
  }

  Context& context_;
  bool from_blender_ = false;
};

/// The default sky as a PFM image: from 0.5 at the horizon to 1 overhead, over a ground of 0.2, with a round
/// window of radiance 10 and 40 degrees across behind the default camera's left shoulder.
std::string sky_image() {
  constexpr int kWidth = 256, kHeight = 128;
  const double half_angle = 20 / kDegrees;
  const Imath::V3d window = Imath::V3d(-0.5, 0.7, 0.6).normalized();
  std::string bytes = concat("PF\n", kWidth, " ", kHeight, "\n-1.0\n");
  for (int row = kHeight - 1; row >= 0; --row) {  // the lowest row first
    const double theta = std::numbers::pi * (row + 0.5) / kHeight;
    for (int column = 0; column < kWidth; ++column) {
      // u = 0.5 at +z, 0.25 at +x (light.proto).
      const double phi = 2 * std::numbers::pi * (0.5 - (column + 0.5) / kWidth);
      const Imath::V3d d(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
      const bool in_window = d.dot(window) > std::cos(half_angle);
      const double radiance = in_window ? 10 : d.y > 0 ? 0.5 + 0.5 * d.y : 0.2;
      const float pixel[3] = {static_cast<float>(radiance), static_cast<float>(radiance),
                              static_cast<float>(radiance)};
      bytes.append(reinterpret_cast<const char*>(pixel), sizeof pixel);
    }
  }
  return bytes;
}

bool emits(const v1::Scene& scene) {
  return std::ranges::any_of(scene.shapes(), [](const v1::Shape& shape) { return shape.has_area_light(); });
}

}  // namespace

void write_camera(Context& context, const std::vector<Node>& nodes, const Extent& extent) {
  const Node* node = choose_camera(context, nodes);
  if (context.diagnostics.has_errors()) return;
  if (node == nullptr) {
    if (!extent.is_empty) context.warn("", "the scene has no camera: one is put where it sees everything");
    write_default_camera(context, extent);
    return;
  }
  const std::size_t index = *index_of(node->json, "camera");
  const Json& camera = *element(&context.document, "cameras", index);
  const std::optional<Imath::M44d> world_from_node = without_scale(node->world_from_node);
  if (!world_from_node) {
    context.error(node->place, "a camera on a node that is flattened by its scale");
    return;
  }
  const std::string place = below("/cameras", index);
  if (text_of(&camera, "type") == "perspective") {
    write_perspective(context, camera);
  } else {
    write_orthographic(context, camera, place);
  }
  // glTF's cameras look along -z, ours along z.
  v1::Camera& message = *context.scene.mutable_camera();
  write_matrix(scaling(1, 1, -1) * *world_from_node, *message.mutable_world_from_camera());
  std::vector<TimedPlacing> motion = node->motion;
  for (TimedPlacing& placing : motion) {
    const std::optional<Imath::M44d> unscaled = without_scale(placing.place);
    if (!unscaled)
      return context.error(node->place, "the camera's node is flattened by its scale as it moves");
    placing.place = scaling(1, 1, -1) * *unscaled;
  }
  write_motion(motion, message);
}

void write_lights(Context& context, BufferTable& buffers, const std::vector<Node>& nodes) {
  constexpr const char* kLights = "KHR_lights_punctual";
  LightWriter writer(context);
  const Json* all = extension(&context.document, kLights);
  for (const Node& node : nodes) {
    const auto index = index_of(extension(node.json, kLights), "light");
    if (index && node.is_in_scene)
      writer.write(node, *element(all, "lights", *index),
                   below(below(below("/extensions", kLights), "lights"), *index));
    if (node.is_in_scene) write_light_profile(context, buffers, node);
  }
  // Converters know neither lengths nor luminances.
  if (!context.is_converted) {
    context.scene.mutable_units()->set_metres(1);
    if (!writer.is_from_blender()) context.scene.mutable_units()->set_cd_per_m2(1);
  }
  // Surfaces that glow are no reason to leave out a sky that was asked for: most are lamps of a dashboard.
  if (!context.scene.lights().empty()) return;
  if (!context.options.default_light) {
    if (!emits(context.scene))
      context.warn("",
                   "the scene has no light, and the picture will be black: --default-light gives it a sky");
    return;
  }
  v1::Light& sky = *context.scene.add_lights();
  sky.set_name("default sky");
  *sky.mutable_infinite()->mutable_image() = context.blobs.add_bytes(sky_image());
  sky.mutable_infinite()->mutable_image()->set_path("default-sky.pfm");
  sky.mutable_infinite()->set_mapping(v1::InfiniteLight::LATITUDE_LONGITUDE);
  sky.mutable_infinite()->set_scale(static_cast<float>(*context.options.default_light));
}

}  // namespace tessera::client::gltf
