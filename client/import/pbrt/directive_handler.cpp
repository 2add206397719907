#include "import/pbrt/directive_handler.h"

#include <utility>

#include "import/input/concat.h"
#include "import/pbrt/matter/media.h"
#include "import/pbrt/render_settings.h"

namespace tessera::client::pbrt {

DirectiveHandler::DirectiveHandler(Context& context)
    : context_(context), textures_(context), materials_(context, textures_) {}

ParameterList DirectiveHandler::list(std::string_view what, const std::string& type,
                                     std::vector<Parameter> parameters, SourceLocation where,
                                     const std::string& attribute_target) {
  static const std::vector<Parameter> kNone;
  const auto defaults = state_.attributes.find(attribute_target);
  return ParameterList(std::move(parameters), defaults == state_.attributes.end() ? kNone : defaults->second,
                       concat(what, " \"", type, "\""), where, state_.color_space, context_.diagnostics);
}

bool DirectiveHandler::require_world(std::string_view directive, SourceLocation where) {
  if (!in_world_) context_.diagnostics.error(where, concat(directive, " is only allowed after WorldBegin"));
  return in_world_;
}

bool DirectiveHandler::require_options(std::string_view directive, SourceLocation where) {
  if (in_world_) context_.diagnostics.error(where, concat(directive, " is only allowed before WorldBegin"));
  return !in_world_;
}

// ---------------------------------------------------------------- transformations

void DirectiveHandler::set_transform(const Imath::M44d& t) {
  if (state_.acts_on_start) state_.ctm.start = t;
  if (state_.acts_on_end) state_.ctm.end = t;
}

void DirectiveHandler::concatenate(const Imath::M44d& t) {
  if (state_.acts_on_start) state_.ctm.start = t * state_.ctm.start;
  if (state_.acts_on_end) state_.ctm.end = t * state_.ctm.end;
}

void DirectiveHandler::name_coordinate_system(const std::string& name) {
  coordinate_systems_[name] = state_.ctm;
}

void DirectiveHandler::use_coordinate_system(const std::string& name, SourceLocation where) {
  const auto known = coordinate_systems_.find(name);
  if (known != coordinate_systems_.end()) {
    state_.ctm = known->second;
  } else {
    context_.diagnostics.warning(
        where, concat("there is no coordinate system \"", name, "\": the transformation stays as it is"));
  }
}

void DirectiveHandler::set_active_transform(std::string_view which, SourceLocation where) {
  if (which != "All" && which != "StartTime" && which != "EndTime") {
    context_.diagnostics.error(where, concat("expected All, StartTime or EndTime, found \"", which, "\""));
    return;
  }
  state_.acts_on_start = which != "EndTime";
  state_.acts_on_end = which != "StartTime";
}

void DirectiveHandler::set_transform_times(double start, double end, SourceLocation where) {
  if (!require_options("TransformTimes", where)) return;
  if (!(start < end)) {
    context_.diagnostics.error(where, "TransformTimes: the end is not after the start");
    return;
  }
  transform_times_[0] = start;
  transform_times_[1] = end;
}

// ---------------------------------------------------------------- blocks and state

void DirectiveHandler::world_begin(SourceLocation where) {
  if (!require_options("WorldBegin", where)) return;
  in_world_ = true;
  state_.ctm = MovingTransform{};
  state_.acts_on_start = state_.acts_on_end = true;
  name_coordinate_system("world");
}

void DirectiveHandler::begin_block(std::string_view directive, SourceLocation where) {
  if (require_world(directive, where)) blocks_.push_back({Block::Kind::kAttribute, where, state_});
}

void DirectiveHandler::end_block(std::string_view directive, SourceLocation where) {
  if (blocks_.empty() || blocks_.back().kind != Block::Kind::kAttribute) {
    std::string problem = concat(directive, " without its beginning");
    if (!blocks_.empty())
      problem += concat(": the block that is open began on line ", blocks_.back().where.line);
    context_.diagnostics.error(where, std::move(problem));
    return;
  }
  state_ = std::move(blocks_.back().saved);
  blocks_.pop_back();
}

void DirectiveHandler::object_begin(const std::string& name, SourceLocation where) {
  if (!require_world("ObjectBegin", where)) return;
  blocks_.push_back({Block::Kind::kObject, where, state_});
  if (current_object_ >= 0 || combination_ != nullptr) {
    context_.diagnostics.error(
        where, concat("ObjectBegin inside of ", combination_ ? "CSGBegin" : "another object"));
    return;
  }
  current_object_ = context_.scene.objects_size();
  context_.scene.add_objects()->set_name(name);
  if (!object_index_.try_emplace(name, current_object_).second) {
    context_.diagnostics.error(where, concat("object \"", name, "\" is defined a second time"));
  }
}

void DirectiveHandler::object_end(SourceLocation where) {
  if (blocks_.empty() || blocks_.back().kind != Block::Kind::kObject) {
    context_.diagnostics.error(where, "ObjectEnd without ObjectBegin");
    return;
  }
  state_ = std::move(blocks_.back().saved);
  blocks_.pop_back();
  current_object_ = -1;
}

void DirectiveHandler::object_instance(const std::string& name, SourceLocation where) {
  if (!require_world("ObjectInstance", where)) return;
  if (combination_ != nullptr) {
    context_.diagnostics.error(where, "ObjectInstance inside of CSGBegin");
    return;
  }
  // Beyond pbrt-v4: objects within objects. Those that are complete hold no object that is not.
  if (current_object_ >= 0) {
    const auto held = object_index_.find(name);
    if (held == object_index_.end() || held->second == current_object_) {
      context_.diagnostics.error(
          where, concat("ObjectInstance inside of an object: object \"", name, "\" is not complete here"));
      return;
    }
  }
  if (!object_index_.contains(name) && ++early_use_[name] <= Diagnostics::kMaxErrors)
    early_instances_.push_back({name, where});
  (current_object_ >= 0 ? instances_by_holder_[current_object_] : world_instances_).add(name, state_.ctm);
}

void DirectiveHandler::set_color_space(const std::string& name, SourceLocation where) {
  if (const std::optional<ColorSpace> space = color_space_of(name)) {
    state_.color_space = *space;
    if (*space != ColorSpace::kSrgb) {
      context_.diagnostics.warning(where, concat("colours in \"", name,
                                                 "\" are converted to linear Rec.709; "
                                                 "images are taken as they are"));
    }
  } else {
    context_.diagnostics.error(
        where, concat("unknown colour space \"", name, "\": expected srgb, dci-p3, rec2020 or aces2065-1"));
  }
}

void DirectiveHandler::set_attributes(const std::string& target, std::vector<Parameter> parameters,
                                      SourceLocation where) {
  if (target != "shape" && target != "light" && target != "material" && target != "medium" &&
      target != "texture") {
    context_.diagnostics.error(where,
                               concat("unknown target \"", target,
                                      "\" of Attribute: expected shape, light, material, medium or texture"));
    return;
  }
  std::vector<Parameter>& defaults = state_.attributes[target];
  defaults.insert(defaults.end(), std::make_move_iterator(parameters.begin()),
                  std::make_move_iterator(parameters.end()));
}

void DirectiveHandler::option(const std::string& name, std::string_view value, SourceLocation where) {
  if (require_options("Option", where)) write_option(context_, name, value, where);
}

// ---------------------------------------------------------------- before the world

void DirectiveHandler::camera(const std::string& type, std::vector<Parameter> parameters,
                              SourceLocation where) {
  if (!require_options("Camera", where)) return;
  camera_ = {type, list("camera", type, std::move(parameters), where)};
  camera_from_world_ = state_.ctm;
  coordinate_systems_["camera"] = {inverse(state_.ctm.start).value_or(Imath::M44d{}),
                                   inverse(state_.ctm.end).value_or(Imath::M44d{})};
  context_.scene.mutable_camera()->set_medium(state_.outside_medium);
}

void DirectiveHandler::film(const std::string& type, std::vector<Parameter> parameters,
                            SourceLocation where) {
  if (require_options("Film", where)) film_ = {type, list("film", type, std::move(parameters), where)};
}

void DirectiveHandler::pixel_filter(const std::string& type, std::vector<Parameter> parameters,
                                    SourceLocation where) {
  if (require_options("PixelFilter", where))
    filter_ = {type, list("filter", type, std::move(parameters), where)};
}

void DirectiveHandler::sampler(const std::string& type, std::vector<Parameter> parameters,
                               SourceLocation where) {
  if (require_options("Sampler", where))
    sampler_ = {type, list("sampler", type, std::move(parameters), where)};
}

void DirectiveHandler::integrator(const std::string& type, std::vector<Parameter> parameters,
                                  SourceLocation where) {
  if (require_options("Integrator", where))
    integrator_ = {type, list("integrator", type, std::move(parameters), where)};
}

void DirectiveHandler::accelerator(const std::string&, std::vector<Parameter>, SourceLocation where) {
  require_options("Accelerator", where);  // how rays find surfaces is the renderer's own affair
}

// ---------------------------------------------------------------- materials, media, lights, shapes

void DirectiveHandler::make_named_medium(const std::string& name, std::vector<Parameter> parameters,
                                         SourceLocation where) {
  ParameterList all = list("medium", name, std::move(parameters), where, "medium");
  ValueReader values(context_, textures_, all);
  const std::string type = values.get_string("type", "");
  std::optional<v1::Medium> medium = read_medium(type, values, state_.ctm.start);
  if (medium) medium->set_name(name);
  // A medium that cannot be read is still known by its name.
  if (!media_.try_emplace(name, NamedMedium{medium ? *std::move(medium) : v1::Medium{}, where}).second) {
    context_.diagnostics.error(where, concat("medium \"", name, "\" is defined a second time"));
  }
}

void DirectiveHandler::medium_interface(const std::string& inside, const std::string& outside,
                                        SourceLocation where) {
  for (const std::string& name : {inside, outside}) {
    if (!name.empty() && !media_.contains(name)) {
      context_.diagnostics.error(where, concat("there is no medium \"", name, "\""));
      return;
    }
  }
  state_.inside_medium = inside;
  state_.outside_medium = outside;
}

void DirectiveHandler::make_named_material(const std::string& name, std::vector<Parameter> parameters,
                                           SourceLocation where) {
  materials_.define_named(name, list("material", name, std::move(parameters), where, "material"));
}

void DirectiveHandler::material(const std::string& type, std::vector<Parameter> parameters,
                                SourceLocation where) {
  if (!require_world("Material", where)) return;
  ParameterList all = list("material", type, std::move(parameters), where, "material");
  state_.material = {materials_.define_anonymous(type, std::move(all)), ""};
}

void DirectiveHandler::texture(const std::string& name, const std::string& value_type,
                               const std::string& type, std::vector<Parameter> parameters,
                               SourceLocation where) {
  if (!require_world("Texture", where)) return;
  if (value_type != "float" && value_type != "spectrum") {
    context_.diagnostics.error(
        where, concat("texture \"", name, "\": expected type float or spectrum, found \"", value_type, "\""));
    return;
  }
  textures_.define(value_type == "float" ? TextureKind::kFloat : TextureKind::kSpectrum, name, type,
                   list("texture", type, std::move(parameters), where, "texture"), state_.ctm.start);
}

void DirectiveHandler::light_source(const std::string& type, std::vector<Parameter> parameters,
                                    SourceLocation where) {
  if (!require_world("LightSource", where)) return;
  ParameterList all = list("light", type, std::move(parameters), where, "light");
  add_light(context_, textures_, type, all, during_exposure(state_.ctm));
}

void DirectiveHandler::area_light_source(const std::string& type, std::vector<Parameter> parameters,
                                         SourceLocation where) {
  if (!require_world("AreaLightSource", where)) return;
  state_.has_area_light = true;
  state_.area_light_type = type;
  state_.area_light = list("area light", type, std::move(parameters), where, "light");
}

void DirectiveHandler::bind_area_light(PendingShape& pending, v1::Shape& shape) {
  if (!state_.has_area_light) return;
  if (current_object_ >= 0) {
    context_.diagnostics.warning(pending.where,
                                 "area lights on the shapes of an object are ignored, as in pbrt-v4");
    return;
  }
  if (std::optional<AreaLightInput> light =
          read_area_light(context_, textures_, state_.area_light_type, state_.area_light)) {
    *shape.mutable_area_light() = std::move(light->light);
    pending.power = light->power;
    pending.mean_image = light->mean_image;
  }
}

void DirectiveHandler::write_state(v1::Shape& shape, PendingShape& pending) {
  shape.set_reverse_orientation(state_.reverse_orientation);
  if (state_.inside_medium != state_.outside_medium) {
    shape.set_interior_medium(state_.inside_medium);
    shape.set_exterior_medium(state_.outside_medium);
  }
  pending.object = current_object_;
  pending.material = state_.material;
  pending.world_from_object = state_.ctm;
  bind_area_light(pending, shape);
}

void DirectiveHandler::keep_shape(v1::Shape message, PendingShape pending) {
  auto* shapes = pending.object >= 0 ? context_.scene.mutable_objects(pending.object)->mutable_shapes()
                                     : context_.scene.mutable_shapes();
  pending.shape = shapes->Add();
  *pending.shape = std::move(message);
  pending_shapes_.push_back(std::move(pending));
}

void DirectiveHandler::shape(const std::string& type, std::vector<Parameter> parameters,
                             SourceLocation where) {
  if (!require_world("Shape", where)) return;
  ParameterList all = list("shape", type, std::move(parameters), where, "shape");
  ValueReader values(context_, textures_, all);
  for (const Imath::M44d& t : {state_.ctm.start, state_.ctm.end}) {
    if (determinant3(t) != 0 && is_finite(t)) continue;
    if (combination_ != nullptr) {
      context_.diagnostics.error(
          where,
          concat(all.owner(), ": its transformation is singular: an operand that is flat is no solid"));
      return;
    }
    context_.diagnostics.warning(where,
                                 concat(all.owner(), ": its transformation is singular: it is left out"));
    return;
  }
  if (type == "curve" && combination_ != nullptr) {
    context_.diagnostics.error(where, "a curve is no closed solid, which operands of CSGBegin are");
    return;
  }
  if (type == "curve") return curve(values, where);
  close_curves();
  v1::Shape message;
  PendingShape pending;
  pending.where = where;
  pending.needs = write_shape(type, values, message);
  if (!pending.needs.kept) return;
  const std::filesystem::path file = context_.diagnostics.file_name(where.file);
  message.set_name(concat(type, ", ", file.filename().string(), ":", where.line));
  if (combination_ != nullptr) return keep_operand(std::move(message), std::move(pending));
  write_state(message, pending);
  keep_shape(std::move(message), std::move(pending));
}

}  // namespace tessera::client::pbrt
