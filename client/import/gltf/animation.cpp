// Animations at one moment: keys, interpolated as glTF 2.0 says (appendix C).
#include <algorithm>
#include <cmath>
#include <utility>

#include "import/gltf/nodes.h"

namespace tessera::client::gltf {
namespace {

std::optional<PosePart> part_of(const std::string& word) {
  if (word == "translation") return PosePart::kTranslation;
  if (word == "rotation") return PosePart::kRotation;
  if (word == "scale") return PosePart::kScale;
  if (word == "weights") return PosePart::kWeights;
  return std::nullopt;
}

std::vector<double> spherical(const Keys& keys, std::size_t key, double t) {
  double cosine = 0;
  for (std::size_t i = 0; i < 4; ++i) cosine += keys.value(key, i) * keys.value(key + 1, i);
  const double sign = cosine < 0 ? -1 : 1, angle = std::acos(std::min(std::abs(cosine), 1.0));
  // Nearly equal rotations have no arc to speak of.
  const double a = angle < 1e-6 ? 1 - t : std::sin((1 - t) * angle) / std::sin(angle);
  const double b = angle < 1e-6 ? t : std::sin(t * angle) / std::sin(angle);
  std::vector<double> result(4);
  for (std::size_t i = 0; i < 4; ++i) result[i] = a * keys.value(key, i) + sign * b * keys.value(key + 1, i);
  return result;
}

std::vector<double> evaluate(const Keys& keys, PosePart part, double time) {
  const auto after = std::upper_bound(keys.times.begin(), keys.times.end(), static_cast<float>(time));
  const std::size_t next = static_cast<std::size_t>(after - keys.times.begin());
  std::vector<double> result(keys.width);
  const std::size_t key = next == 0 ? 0 : next - 1;
  if (next == 0 || next == keys.times.size() || keys.steps) {
    for (std::size_t i = 0; i < keys.width; ++i) result[i] = keys.value(key, i);
    return result;
  }
  const double span = double{keys.times[next]} - keys.times[key];
  const double t = std::clamp((time - keys.times[key]) / span, 0.0, 1.0), t2 = t * t, t3 = t2 * t;
  if (keys.cubic) {
    for (std::size_t i = 0; i < keys.width; ++i) {
      result[i] = (2 * t3 - 3 * t2 + 1) * keys.value(key, i) + span * (t3 - 2 * t2 + t) * keys.at(key, 2, i) +
                  (3 * t2 - 2 * t3) * keys.value(next, i) + span * (t3 - t2) * keys.at(next, 0, i);
    }
    return result;
  }
  if (part == PosePart::kRotation) return spherical(keys, key, t);
  for (std::size_t i = 0; i < keys.width; ++i) {
    result[i] = (1 - t) * keys.value(key, i) + t * keys.value(next, i);
  }
  return result;
}

class ChannelReader {
 public:
  ChannelReader(Context& context, AccessorTable& accessors, const std::vector<Node>& nodes)
      : context_(context), accessors_(accessors), nodes_(nodes) {}

  /// Checks the animation; with `plays`, its channels are kept.
  void run(const Json& animation, const std::string& place, bool plays) {
    for (std::size_t c = 0; c < size_of(&animation, "channels") && !context_.diagnostics.full(); ++c) {
      const Json& channel = *element(&animation, "channels", c);
      const std::string at = below(below(place, "channels"), c);
      const std::size_t sampler = *index_of(&channel, "sampler");
      const Json* found = element(&animation, "samplers", sampler);
      const Json* target = member(&channel, "target");
      const std::optional<std::size_t> node = index_of(target, "node");
      const std::optional<PosePart> part = part_of(text_of(target, "path"));
      if (!node) continue;  // its target is an extension's
      if (!part) {
        context_.error(below(below(at, "target"), "path"),
                       "expected translation, rotation, scale or weights");
        continue;
      }
      if (nodes_[*node].pose.matrix && part != PosePart::kWeights) {
        context_.error(below(at, "target"), concat("node ", *node, " has a matrix, which is not animated"));
        continue;
      }
      const std::string of = below(below(place, "samplers"), sampler);
      std::optional<Keys> keys = read_keys(*found, *part, nodes_[*node], of);
      if (keys && plays) channels_.push_back({*node, *part, *std::move(keys)});
    }
  }

  std::vector<Channel> channels() && { return std::move(channels_); }

 private:
  std::size_t targets_of(const Node& node) const {
    const std::optional<std::size_t> mesh = index_of(node.json, "mesh");
    if (!mesh) return 0;
    return size_of(element(element(&context_.document, "meshes", *mesh), "primitives", 0), "targets");
  }

  std::optional<Keys> read_keys(const Json& sampler, PosePart part, const Node& node,
                                const std::string& place) {
    const std::size_t input = *index_of(&sampler, "input"), output = *index_of(&sampler, "output");
    const Accessor &times = accessors_[input], &values = accessors_[output];
    Keys keys;
    const std::string word = text_of(&sampler, "interpolation", "LINEAR");
    keys.steps = word == "STEP", keys.cubic = word == "CUBICSPLINE";
    keys.width = part == PosePart::kRotation ? 4 : part == PosePart::kWeights ? targets_of(node) : 3;
    const int components = part == PosePart::kWeights ? 1 : static_cast<int>(keys.width);
    const std::size_t expected =
        times.count * (keys.cubic ? 3 : 1) * (part == PosePart::kWeights ? keys.width : 1);
    if (values.components != components || values.count != expected) {
      context_.error(below(place, "output"),
                     concat("expected ", expected, " elements of ", components, " components, found ",
                            values.count, " of ", values.components));
      return std::nullopt;
    }
    std::optional<std::vector<float>> numbers = accessors_.read(input);
    if (!numbers) return std::nullopt;
    keys.times = *std::move(numbers);
    if (std::ranges::adjacent_find(keys.times, std::ranges::greater_equal()) != keys.times.end() ||
        keys.times.front() < 0) {
      context_.error(below(place, "input"), "times are below 0, or do not ascend");
      return std::nullopt;
    }
    numbers = accessors_.read(output);
    if (!numbers) return std::nullopt;
    keys.values = *std::move(numbers);
    return keys;
  }

  Context& context_;
  AccessorTable& accessors_;
  const std::vector<Node>& nodes_;
  std::vector<Channel> channels_;
};

}  // namespace

void apply(const Channel& channel, double time, Pose& pose) {
  const std::vector<double> value = evaluate(channel.keys, channel.part, time);
  switch (channel.part) {
    case PosePart::kTranslation:
      pose.translation = {value[0], value[1], value[2]};
      break;
    case PosePart::kScale:
      pose.scale = {value[0], value[1], value[2]};
      break;
    case PosePart::kRotation:
      std::ranges::copy(value, pose.rotation);
      break;
    case PosePart::kWeights:
      pose.weights = value;
      break;
  }
}

std::vector<Channel> read_animations(Context& context, AccessorTable& accessors,
                                     const std::vector<Node>& nodes) {
  ChannelReader reader(context, accessors, nodes);
  const std::string& wanted = context.options.animation;
  bool found = false;
  for (std::size_t i = 0; i < size_of(&context.document, "animations"); ++i) {
    const Json& animation = *element(&context.document, "animations", i);
    const bool chosen = wanted.empty() || text_of(&animation, "name") == wanted || concat(i) == wanted;
    found = found || chosen;
    reader.run(animation, below("/animations", i), chosen && context.options.time.has_value());
  }
  if (!wanted.empty() && !found)
    context.error("/animations", concat("there is no animation \"", wanted, "\""));
  if (!wanted.empty() && !context.options.time)
    context.warn("/animations", "an animation is chosen, but no time: nodes stay where they are");
  if (context.options.shutter > 0 && !context.options.time)
    context.warn("/animations", "the shutter is open for a while, but at no time: nodes stay where they are");
  return std::move(reader).channels();
}

}  // namespace tessera::client::gltf
