#include "import/tessera_scene/check_scene.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "base/nearest_name.h"
#include "expression/expression.h"
#include "import/input/concat.h"
#include "import/tessera_scene/animation.h"
#include "optics/film_gauge.h"
#include "spectra/matter/dispersion.h"
#include "spectra/sensor/bands.h"
#include "spectra/sensor/sensor_name.h"
#include "wire/exposure.h"
#include "wire/scene_numbers.h"

namespace tessera::client::tessera_scene {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// Kind of element that a field of strings refers to.
struct ReferenceField {
  std::string_view field;  // without "tessera.v1."
  std::string_view kind;
};

constexpr std::string_view kPackage = "tessera.v1.";
constexpr ReferenceField kReferences[] = {
    {"Shape.material", "material"},         {"Shape.interior_medium", "medium"},
    {"Shape.exterior_medium", "medium"},    {"Camera.medium", "medium"},
    {"Instance.object", "object"},          {"PackedInstances.Run.object", "object"},
    {"Material.back", "material"},          {"Material.normal_texture", "texture"},
    {"MixMaterial.a", "material"},          {"MixMaterial.b", "material"},
    {"AreaLight.texture", "texture"},       {"SpotLight.texture", "texture"},
    {"ProjectionLight.texture", "texture"}, {"GoniometricLight.texture", "texture"},
    {"FloatValue.texture", "texture"},      {"SpectrumValue.texture", "texture"}};

/// Fields that hold what a surface gives back of the light.
constexpr std::string_view kReflectances[] = {"reflectance", "transmittance", "base_color"};

std::string_view name_in_package(const FieldDescriptor& field) {
  return std::string_view(field.full_name()).substr(kPackage.size());
}

/// Settings that are words of a syntax of their own, and names of films.
absl::Status check_setting(const std::string& text, const FieldDescriptor& field) {
  const std::string_view name = name_in_package(field);
  if (text.empty()) return absl::OkStatus();
  if (name == "RenderSettings.sensor") return spectra::parse_sensor(text).status();
  if (name == "RenderSettings.white_balance") return spectra::parse_white_balance(text).status();
  if (name == "RenderSettings.film") return spectra::parse_film(text).status();
  if (name == "RenderSettings.exposure") return wire::check_exposure_words(text);
  if (field.name() == "film_gauge" && optics::find_film_gauge(text) == nullptr)
    return absl::InvalidArgumentError(optics::unknown_film_gauge(text));
  return absl::OkStatus();
}

class SceneCheck {
 public:
  SceneCheck(const v1::Scene& scene, std::uint32_t file, Diagnostics& diagnostics)
      : scene_(scene), file_(file), diagnostics_(diagnostics) {}

  void run(Locations* locations) {
    collect("texture", scene_.textures(), "textures", locations);
    collect("material", scene_.materials(), "materials", locations);
    collect("medium", scene_.media(), "media", locations);
    collect("object", scene_.objects(), "objects", locations);
    visit(scene_, locations, {file_, 0, 0});
    check_tracks(locations);
    if (!has_light()) diagnostics_.warning({file_, 0, 0}, "the scene has no light: the image will be black");
  }

 private:
  /// The place of a field, or else of what it stands in.
  SourceLocation locate(Locations* locations, const FieldDescriptor* field, int index,
                        SourceLocation outer) const {
    if (locations == nullptr) return outer;
    const auto location = locations->GetLocation(field, index);
    if (location.line < 0) return outer;
    return {file_, static_cast<std::uint32_t>(location.line + 1),
            static_cast<std::uint32_t>(location.column + 1)};
  }

  template <typename Elements>
  void collect(const std::string& kind, const Elements& elements, const char* field_name,
               Locations* locations) {
    const FieldDescriptor* field = v1::Scene::descriptor()->FindFieldByName(field_name);
    std::set<std::string>& names = names_[kind];
    for (int i = 0; i < elements.size(); ++i) {
      if (names.insert(elements[i].name()).second) continue;
      diagnostics_.error(locate(locations, field, i, {file_, 0, 0}),
                         concat(kind, " \"", elements[i].name(), "\": the name is used twice"));
    }
  }

  void visit(const Message& message, Locations* locations, SourceLocation where) {
    const auto* reflection = message.GetReflection();
    check_kind(message, where);
    std::vector<const FieldDescriptor*> fields;
    reflection->ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING && !field->is_repeated()) {
        const std::string text = reflection->GetString(message, field);
        const SourceLocation place = locate(locations, field, -1, where);
        check_reference(text, *field, place);
        if (const absl::Status fault = check_setting(text, *field); !fault.ok())
          diagnostics_.error(place, concat(field->name(), ": ", std::string(fault.message())));
      }
      if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
      const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
      for (int i = 0; i < count && !diagnostics_.full(); ++i) {
        const int index = field->is_repeated() ? i : -1;
        const Message& child = field->is_repeated() ? reflection->GetRepeatedMessage(message, field, i)
                                                    : reflection->GetMessage(message, field);
        const SourceLocation place = locate(locations, field, index, where);
        check_reflectance(child, *field, place);
        visit(child, locations == nullptr ? nullptr : locations->GetTreeForNested(field, index), place);
      }
    }
  }

  /// The first fault of the animation, at the track that has it, or else where the animation begins.
  void check_tracks(Locations* locations) {
    const absl::Status status = check_animation(scene_);
    if (status.ok()) return;
    const v1::Animation& animation = scene_.animation();
    const FieldDescriptor* field = v1::Scene::descriptor()->FindFieldByName("animation");
    SourceLocation where = locate(locations, field, -1, {file_, 0, 0});
    for (int i = 0; i < animation.tracks_size(); ++i) {
      if (check_track(scene_, i).ok()) continue;
      Locations* inside = locations == nullptr ? nullptr : locations->GetTreeForNested(field, -1);
      where = locate(inside, v1::Animation::descriptor()->FindFieldByName("tracks"), i, where);
      break;
    }
    diagnostics_.error(where, std::string(status.message()));
  }

  void check_kind(const Message& message, SourceLocation where) {
    const auto missing = [&](std::string_view what) {
      diagnostics_.error(where, concat("a ", what, " without a kind"));
    };
    if (const auto* material = google::protobuf::DynamicCastToGenerated<v1::Material>(&message)) {
      if (material->kind_case() == v1::Material::KIND_NOT_SET) missing("material");
      if (const std::string fault = wire::index_fault(*material); !fault.empty())
        diagnostics_.error(where, concat("material \"", material->name(), "\": ", fault));
    } else if (const auto* texture = google::protobuf::DynamicCastToGenerated<v1::Texture>(&message)) {
      if (texture->kind_case() == v1::Texture::KIND_NOT_SET) missing("texture");
    } else if (const auto* shape = google::protobuf::DynamicCastToGenerated<v1::Shape>(&message)) {
      if (shape->kind_case() == v1::Shape::KIND_NOT_SET) missing("shape");
    } else if (const auto* implicit =
                   google::protobuf::DynamicCastToGenerated<v1::ImplicitSurface>(&message)) {
      if (const auto parsed = expression::parse(implicit->expression()); !parsed.ok())
        diagnostics_.error(where, concat("expression, ", std::string(parsed.status().message())));
    } else if (const auto* dispersion = google::protobuf::DynamicCastToGenerated<v1::Dispersion>(&message)) {
      check_glass(*dispersion, where);
    } else if (const auto* light = google::protobuf::DynamicCastToGenerated<v1::Light>(&message)) {
      if (light->kind_case() == v1::Light::KIND_NOT_SET) missing("light");
    } else if (const auto* matrix = google::protobuf::DynamicCastToGenerated<v1::Matrix>(&message)) {
      const int size = matrix->elements_size();
      if (size != 0 && size != 16)
        diagnostics_.error(where, concat("a matrix of ", size, " elements: expected 16"));
    }
  }

  void check_glass(const v1::Dispersion& dispersion, SourceLocation where) {
    if (!dispersion.has_glass() || spectra::find_dispersion(dispersion.glass())) return;
    diagnostics_.error(where, concat("there is no glass \"", dispersion.glass(), "\"",
                                     base::did_you_mean(dispersion.glass(), spectra::dispersion_names())));
  }

  void check_reference(const std::string& name, const FieldDescriptor& field, SourceLocation where) {
    if (name.empty()) return;
    for (const ReferenceField& reference : kReferences) {
      if (reference.field != name_in_package(field)) continue;
      const std::set<std::string>& names = names_[std::string(reference.kind)];
      if (names.contains(name)) return;
      const std::string nearest = base::nearest_name(name, {names.begin(), names.end()});
      diagnostics_.error(where, concat("there is no ", reference.kind, " \"", name, "\"",
                                       nearest.empty() ? "" : concat(": did you mean \"", nearest, "\"?")));
    }
  }

  void check_reflectance(const Message& message, const FieldDescriptor& field, SourceLocation where) {
    const auto* value = google::protobuf::DynamicCastToGenerated<v1::SpectrumValue>(&message);
    if (value == nullptr || !value->has_constant()) return;
    for (const std::string_view name : kReflectances) {
      if (field.name() != name) continue;
      const v1::Spectrum& spectrum = value->constant();
      double largest = 0;
      if (spectrum.kind_case() == v1::Spectrum::kConstant) largest = spectrum.constant();
      if (spectrum.has_rgb())
        largest = std::max({spectrum.rgb().r(), spectrum.rgb().g(), spectrum.rgb().b()});
      if (largest <= 1) return;
      diagnostics_.warning(where, concat("a ", name, " of ", largest, " gives back more light than it gets"));
    }
  }

  bool has_light() const {
    if (scene_.lights_size() > 0) return true;
    const auto shines = [](const v1::Shape& shape) { return shape.has_area_light(); };
    if (std::ranges::any_of(scene_.shapes(), shines)) return true;
    for (const v1::Object& object : scene_.objects()) {
      if (std::ranges::any_of(object.shapes(), shines)) return true;
    }
    for (const v1::Medium& medium : scene_.media()) {
      if (medium.has_emission()) return true;
    }
    return false;
  }

  const v1::Scene& scene_;
  std::uint32_t file_;
  Diagnostics& diagnostics_;
  std::map<std::string, std::set<std::string>> names_;
};

}  // namespace

void check_scene(const v1::Scene& scene, std::uint32_t file, Locations* locations, Diagnostics& diagnostics) {
  SceneCheck(scene, file, diagnostics).run(locations);
}

}  // namespace tessera::client::tessera_scene
