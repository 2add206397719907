// Skins and animations.
#include <map>
#include <utility>

#include "import/gltf/rules/rules.h"

namespace tessera::client::gltf {
namespace motion_rules {

constexpr std::string_view kNormalized = " i8n u8n i16n u16n ";

class AnimationCheck {
 public:
  AnimationCheck(Context& context, AccessorTable& accessors, AccessorUses& uses)
      : context_(context), accessors_(accessors), uses_(uses) {}

  void check(const Json& animation, const std::string& place) {
    std::map<std::pair<std::size_t, std::string>, std::size_t> targets;
    for (std::size_t s = 0; s < size_of(&animation, "samplers") && !context_.diagnostics.full(); ++s)
      check_sampler(*element(&animation, "samplers", s), below(below(place, "samplers"), s));
    for (std::size_t c = 0; c < size_of(&animation, "channels") && !context_.diagnostics.full(); ++c) {
      const Json& channel = *element(&animation, "channels", c);
      const std::string at = below(below(place, "channels"), c);
      const Json* sampler = element(&animation, "samplers", size_member(channel, "sampler"));
      const Json* target = member(&channel, "target");
      if (sampler == nullptr) {
        context_.error(below(at, "sampler"), concat("there is no sampler ", size_member(channel, "sampler")));
        continue;
      }
      const auto node = index_of(target, "node");
      if (!node) continue;  // its target is an extension's
      const std::string path = text_of(target, "path");
      const auto [known, is_new] = targets.try_emplace({*node, path}, c);
      if (!is_new) context_.error(below(at, "target"), concat("channel ", known->second, " moves the same"));
      check_output(*sampler, path, *node, at);
    }
  }

 private:
  void check_sampler(const Json& sampler, const std::string& place) {
    const std::size_t input = *index_of(&sampler, "input"), output = *index_of(&sampler, "output");
    const std::string at = below(place, "input");
    uses_.add(input, Usage::kTimes, at);
    uses_.add(output, Usage::kKeys, below(place, "output"));
    const bool is_spline = text_of(&sampler, "interpolation") == "CUBICSPLINE";
    const auto [known, is_new] = splines_.try_emplace(output, is_spline);
    if (known->second != is_spline)
      context_.error(below(place, "output"),
                     concat("accessor ", output, " is used with and without CUBICSPLINE"));
    const Accessor& times = accessors_[input];
    if (times.format != "SCALAR f32")
      context_.error(at, concat("accessor ", input, " is ", times.format, ", not SCALAR f32"));
    const Json* json = element(&context_.document, "accessors", input);
    if (member(json, "min") == nullptr || member(json, "max") == nullptr)
      context_.error(at, concat("accessor ", input, " has times, but no min and max"));
    if (is_spline && times.count < 2) context_.error(at, "a CUBICSPLINE of one key");
  }

  void check_output(const Json& sampler, const std::string& path, std::size_t node,
                    const std::string& place) {
    const std::size_t output = *index_of(&sampler, "output");
    const Accessor& keys = accessors_[output];
    const bool is_spline = text_of(&sampler, "interpolation") == "CUBICSPLINE";
    const Json* node_json = element(&context_.document, "nodes", node);
    const std::string at = below(below(place, "target"), "path");
    const std::string type = path == "weights" ? "SCALAR " : path == "rotation" ? "VEC4 " : "VEC3 ";
    if (path == "rotation" && keys.format == "VEC4 f32") {
      uses_.demands(output).rotations = true;
      uses_.demands(output).spline_part = is_spline ? 3 : 0;
    }
    const bool takes_integers = path == "weights" || path == "rotation";
    const bool fits =
        keys.format == type + "f32" ||
        (takes_integers && keys.format.starts_with(type) &&
         kNormalized.find(concat(" ", keys.format.substr(type.size()), " ")) != std::string_view::npos);
    if (!fits)
      context_.error(at, concat("the values of ", path, " are ", keys.format, " (accessor ", output, ")"));
    if (path != "weights") return;
    const auto mesh = index_of(node_json, "mesh");
    const Json* primitive =
        mesh ? element(element(&context_.document, "meshes", *mesh), "primitives", 0) : nullptr;
    if (size_of(primitive, "targets") == 0)
      context_.error(at, concat("node ", node, " has no morph targets"));
  }

  Context& context_;
  AccessorTable& accessors_;
  AccessorUses& uses_;
  std::map<std::size_t, bool> splines_;  // outputs
};

}  // namespace motion_rules

void check_animations(Context& context, AccessorTable& accessors, AccessorUses& uses) {
  motion_rules::AnimationCheck check(context, accessors, uses);
  for (std::size_t i = 0; i < size_of(&context.document, "animations") && !context.diagnostics.full(); ++i)
    check.check(*element(&context.document, "animations", i), below("/animations", i));
}

void check_skins(Context& context, AccessorTable& accessors, AccessorUses& uses) {
  for (std::size_t i = 0; i < size_of(&context.document, "skins") && !context.diagnostics.full(); ++i) {
    const Json* skin = element(&context.document, "skins", i);
    const auto matrices = index_of(skin, "inverseBindMatrices");
    if (!matrices) continue;
    const std::string place = below(below("/skins", i), "inverseBindMatrices");
    uses.add(*matrices, Usage::kInverseBindMatrices, place);
    const Accessor& accessor = accessors[*matrices];
    if (accessor.format != "MAT4 f32")
      context.error(place, concat("accessor ", *matrices, " is ", accessor.format, ", not MAT4 f32"));
    if (accessor.count < size_of(skin, "joints"))
      context.error(place, concat(accessor.count, " matrices for ", size_of(skin, "joints"), " joints"));
    uses.demands(*matrices).placings = true;
  }
}

}  // namespace tessera::client::gltf
