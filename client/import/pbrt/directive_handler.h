// pbrt's graphics state: takes directives in the order of the file and makes the scene.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "import/input/instance_list.h"
#include "import/pbrt/camera_film.h"
#include "import/pbrt/lights.h"
#include "import/pbrt/matter/materials.h"
#include "import/pbrt/shapes/curves.h"
#include "import/pbrt/shapes/shapes.h"

namespace tessera::client::pbrt {

/// State that AttributeBegin saves and AttributeEnd restores.
struct GraphicsState {
  MovingTransform ctm;  // world_from_object inside the world block, camera_from_world before it
  bool reverse_orientation = false;
  bool acts_on_start = true, acts_on_end = true;  // ActiveTransform
  MaterialRef material;
  std::string inside_medium, outside_medium;
  bool has_area_light = false;
  std::string area_light_type;
  ParameterList area_light;
  ColorSpace color_space = ColorSpace::kSrgb;
  std::map<std::string, std::vector<Parameter>> attributes;  // defaults by target: "shape", "light", ...
};

class DirectiveHandler {
 public:
  explicit DirectiveHandler(Context& context);

  // Transformations.
  void set_transform(const Imath::M44d& t);
  void concatenate(const Imath::M44d& t);
  void name_coordinate_system(const std::string& name);
  void use_coordinate_system(const std::string& name, SourceLocation where);
  void set_active_transform(std::string_view which, SourceLocation where);
  void set_transform_times(double start, double end, SourceLocation where);

  // Blocks and state.
  void world_begin(SourceLocation where);
  // AttributeBegin and AttributeEnd; TransformBegin and TransformEnd are the same in pbrt-v4.
  void begin_block(std::string_view directive, SourceLocation where);
  void end_block(std::string_view directive, SourceLocation where);
  void object_begin(const std::string& name, SourceLocation where);
  void object_end(SourceLocation where);
  void object_instance(const std::string& name, SourceLocation where);
  void csg_end(SourceLocation where);
  void reverse_orientation() { state_.reverse_orientation = !state_.reverse_orientation; }
  void set_color_space(const std::string& name, SourceLocation where);
  void set_attributes(const std::string& target, std::vector<Parameter> parameters, SourceLocation where);
  void option(const std::string& name, std::string_view value, SourceLocation where);
  bool in_world() const { return in_world_; }
  /// Import reads a file without letting it change the state.
  GraphicsState state() const { return state_; }
  void restore(GraphicsState state) { state_ = std::move(state); }

  /// A directive of the form `Name "type" parameters`, before or inside the world block.
  using Typed = void (DirectiveHandler::*)(const std::string& type, std::vector<Parameter> parameters,
                                           SourceLocation where);
  void camera(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void film(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void pixel_filter(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void sampler(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void integrator(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void accelerator(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void make_named_medium(const std::string& name, std::vector<Parameter> parameters, SourceLocation where);
  void make_named_material(const std::string& name, std::vector<Parameter> parameters, SourceLocation where);
  void material(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void light_source(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void area_light_source(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  void shape(const std::string& type, std::vector<Parameter> parameters, SourceLocation where);
  /// Shapes up to the csg_end() that belongs to it are operands.
  void csg_begin(const std::string& operation, std::vector<Parameter> parameters, SourceLocation where);

  void texture(const std::string& name, const std::string& value_type, const std::string& type,
               std::vector<Parameter> parameters, SourceLocation where);
  void named_material(const std::string& name) { state_.material = {-1, name}; }
  void medium_interface(const std::string& inside, const std::string& outside, SourceLocation where);

  /// Color space for parameters that are being read.
  ColorSpace color_space() const { return state_.color_space; }

  /// At the end of the file: reads the meshes, converts what is used and checks that all is closed.
  void finish();

 private:
  struct Block {
    enum class Kind { kAttribute, kObject, kCsg } kind;
    SourceLocation where;
    GraphicsState saved;
  };
  /// A shape whose message waits for its mesh and its material.
  struct PendingShape {
    v1::Shape* shape = nullptr;
    int object = -1;  // index in the scene; -1: in the world
    MaterialRef material;
    MovingTransform world_from_object;
    ShapeResult needs;
    double power = 0;       // power of its area light, where that is given
    double mean_image = 1;  // mean luminance of the area light's image
    SourceLocation where;
    bool is_csg_operand = false;
  };
  /// An instance of an object that was not known yet.
  struct EarlyInstance {
    std::string object;
    SourceLocation where;
  };
  /// Curves that follow one another under the same state, on their way into one shape.
  struct OpenCurves {
    CurveBatch batch;
    v1::Shape looks;  // all of the shape but its geometry and its name
    PendingShape pending;
  };

  ParameterList list(std::string_view what, const std::string& type, std::vector<Parameter> parameters,
                     SourceLocation where, const std::string& attribute_target = "");
  bool require_world(std::string_view directive, SourceLocation where);
  bool require_options(std::string_view directive, SourceLocation where);
  void bind_area_light(PendingShape& pending, v1::Shape& shape);
  /// Takes a shape into the scene whose geometry is written.
  void keep_shape(v1::Shape message, PendingShape pending);
  /// All that the graphics state says of a shape.
  void write_state(v1::Shape& shape, PendingShape& pending);

  // gather_curves.cpp
  void curve(ValueReader& values, SourceLocation where);
  void close_curves();

  // shapes/csg.cpp
  void begin_combination(const std::string& what, SourceLocation where,
                         const std::function<void(v1::Csg&)>& group);
  void keep_operand(v1::Shape message, PendingShape pending);

  /// The camera's, which stands before whatever moves.
  const ShutterTimes& shutter();
  MovingTransform during_exposure(const MovingTransform& moving);
  void place_shapes();
  void place_instances();
  void place_camera();
  void add_media();
  void load_meshes();
  void resolve_materials_and_textures();
  void resolve_powers();
  void note_places();

  Context& context_;
  SceneTextures textures_;
  MaterialTable materials_;
  GraphicsState state_;
  bool in_world_ = false;
  std::vector<Block> blocks_;
  std::map<std::string, MovingTransform> coordinate_systems_;
  std::map<std::string, int> object_index_;
  int current_object_ = -1;
  std::vector<PendingShape> pending_shapes_;
  InstanceList world_instances_;
  std::map<int, InstanceList> instances_by_holder_;  // objects that hold others
  std::vector<EarlyInstance> early_instances_;       // kMaxErrors of each object at most
  std::map<std::string, std::size_t> early_use_;     // how many of them there are
  std::optional<OpenCurves> open_curves_;
  struct NamedMedium {
    v1::Medium message;
    SourceLocation where;
  };
  std::map<std::string, NamedMedium> media_;

  // The combination of solids that is open, among pending_shapes_, and the state that it began with.
  v1::Csg* combination_ = nullptr;
  int csg_depth_ = 0;
  Imath::M44d combination_from_world_;
  MovingTransform combination_to_world_;
  std::pair<std::string, std::string> combination_media_;

  Directive camera_{"perspective", {}};
  Directive film_{"rgb", {}};
  Directive filter_{"gaussian", {}};
  Directive sampler_{"zsobol", {}};
  Directive integrator_{"volpath", {}};
  MovingTransform camera_from_world_;
  double transform_times_[2] = {0, 1};
  std::optional<ShutterTimes> shutter_;
};

}  // namespace tessera::client::pbrt
