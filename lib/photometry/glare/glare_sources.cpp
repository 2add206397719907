#include "photometry/glare/glare_sources.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace tessera::photometry {
namespace {

double dot(const ViewDirection& a, const ViewDirection& b) {
  return a.right * b.right + a.up * b.up + a.forward * b.forward;
}

ViewDirection unit(const ViewDirection& v) {
  const double length = std::sqrt(dot(v, v));
  return length > 0 ? ViewDirection{v.right / length, v.up / length, v.forward / length} : ViewDirection{};
}

double angle_between(const ViewDirection& a, const ViewDirection& b) {
  return std::acos(std::clamp(dot(a, b), -1.0, 1.0));
}

/// Sums over the pixels of a source.
struct Sums {
  double solid_angle = 0, light = 0, illuminance = 0;  // light: luminance times solid angle
  ViewDirection direction{0, 0, 0};                    // weighed by light
  std::size_t pixels = 0;

  void add(const Sums& other) {
    solid_angle += other.solid_angle, light += other.light, illuminance += other.illuminance;
    direction.right += other.direction.right, direction.up += other.direction.up;
    direction.forward += other.direction.forward;
    pixels += other.pixels;
  }
  GlareSource source() const {
    GlareSource result{.middle = unit(direction),
                       .luminance = light / solid_angle,
                       .solid_angle = solid_angle,
                       .illuminance = illuminance,
                       .pixels = pixels};
    result.position_index = position_index(result.middle);
    return result;
  }
};

Sums sums_of(const LuminancePicture& picture, std::size_t i) {
  const ViewDirection& w = picture.directions[i];
  const double light = picture.luminances[i] * picture.solid_angles[i];
  return {picture.solid_angles[i],
          light,
          light * std::max(w.forward, 0.0),
          {w.right * light, w.up * light, w.forward * light},
          1};
}

/// Sets of pixels, or of sources, that are joined two at a time.
class Joined {
 public:
  explicit Joined(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    const std::size_t ra = root(a), rb = root(b);
    parent_[std::max(ra, rb)] = std::min(ra, rb);
  }

 private:
  std::vector<std::size_t> parent_;
};

/// Number of the group of each pixel from 0 on, in the order of their first pixels; -1: dark.
std::vector<std::int32_t> groups_that_touch(const LuminancePicture& picture, double threshold,
                                            std::size_t& groups) {
  const auto width = static_cast<std::size_t>(picture.width);
  const auto is_bright = [&](std::size_t i) {
    return picture.solid_angles[i] > 0 && picture.luminances[i] > threshold;
  };
  Joined joined(picture.size());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (!is_bright(i)) continue;
    const std::size_t x = i % width;
    if (x > 0 && is_bright(i - 1)) joined.join(i, i - 1);
    if (i < width) continue;
    if (is_bright(i - width)) joined.join(i, i - width);
    if (x > 0 && is_bright(i - width - 1)) joined.join(i, i - width - 1);
    if (x + 1 < width && is_bright(i - width + 1)) joined.join(i, i - width + 1);
  }
  std::vector<std::int32_t> number(picture.size(), -1);
  groups = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (!is_bright(i)) continue;
    const std::size_t root = joined.root(i);  // the first of its pixels
    number[i] = root == i ? static_cast<std::int32_t>(groups++) : number[root];
  }
  return number;
}

/// Joins the nearest two sources until none are nearer than the radius. Returns which one each has become.
std::vector<std::size_t> merge_neighbours(std::vector<Sums>& sums, double radius) {
  Joined joined(sums.size());
  std::vector<std::size_t> alive(sums.size());
  std::iota(alive.begin(), alive.end(), std::size_t{0});
  // The nearest other of each, which only a merge changes.
  struct Neighbour {
    std::size_t other = 0;
    double angle = 4;
  };
  std::vector<Neighbour> nearest(sums.size());
  const auto look = [&](std::size_t a) {
    nearest[a] = {};
    for (const std::size_t b : alive) {
      if (b == a) continue;
      const double angle = angle_between(unit(sums[a].direction), unit(sums[b].direction));
      if (angle < nearest[a].angle) nearest[a] = {b, angle};
    }
  };
  for (const std::size_t a : alive) look(a);
  while (alive.size() > 1) {
    const std::size_t a = *std::ranges::min_element(
        alive, [&](std::size_t x, std::size_t y) { return nearest[x].angle < nearest[y].angle; });
    if (!(nearest[a].angle < radius)) break;
    const std::size_t kept = std::min(a, nearest[a].other), gone = std::max(a, nearest[a].other);
    sums[kept].add(sums[gone]);
    joined.join(kept, gone);
    std::erase(alive, gone);
    for (const std::size_t b : alive) {
      if (b == kept || nearest[b].other == kept || nearest[b].other == gone) {
        look(b);
      } else if (const double angle = angle_between(unit(sums[b].direction), unit(sums[kept].direction));
                 angle < nearest[b].angle) {
        nearest[b] = {kept, angle};
      }
    }
  }
  std::vector<std::size_t> became(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) became[i] = joined.root(i);
  return became;
}

double weight_of(const GlareSource& s) {
  return s.luminance * s.luminance * s.solid_angle / (s.position_index * s.position_index);
}

/// Merging is quadratic in the groups of pixels; only noisy pictures have more.
constexpr std::size_t kMostGroups = 4096;

}  // namespace

absl::Status check_picture(const LuminancePicture& picture) {
  const std::size_t size = picture.size();
  if (picture.width <= 0 || picture.height <= 0 || picture.luminances.size() != size ||
      picture.directions.size() != size || picture.solid_angles.size() != size) {
    return absl::InvalidArgumentError(
        absl::StrCat("a picture of ", picture.width, " x ", picture.height,
                     " pixels has not as many luminances, directions and solid angles"));
  }
  const auto is_amount = [](double value) { return value >= 0 && std::isfinite(value); };
  if (!std::ranges::all_of(picture.luminances, is_amount) ||
      !std::ranges::all_of(picture.solid_angles, is_amount))
    return absl::InvalidArgumentError("a luminance or a solid angle is negative or not finite");
  return absl::OkStatus();
}

double mean_luminance(const LuminancePicture& picture, const TaskZone& task) {
  const double cosine = std::cos(task.radius_degrees * std::numbers::pi / 180);
  const ViewDirection middle = unit(task.middle);
  double light = 0, solid_angle = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (task.radius_degrees > 0 && dot(picture.directions[i], middle) < cosine) continue;
    light += picture.luminances[i] * picture.solid_angles[i];
    solid_angle += picture.solid_angles[i];
  }
  return solid_angle > 0 ? light / solid_angle : 0;
}

FoundSources find_glare_sources(const LuminancePicture& picture, const SourceSearch& search) {
  FoundSources found;
  found.threshold =
      search.threshold > 0 ? search.threshold : search.factor * mean_luminance(picture, search.task);
  std::size_t groups = 0;
  const std::vector<std::int32_t> group_of = groups_that_touch(picture, found.threshold, groups);
  std::vector<Sums> sums(groups);
  for (std::size_t i = 0; i < picture.size(); ++i)
    if (group_of[i] >= 0) sums[static_cast<std::size_t>(group_of[i])].add(sums_of(picture, i));
  std::vector<std::size_t> became(groups);
  std::iota(became.begin(), became.end(), std::size_t{0});
  found.merged = groups <= kMostGroups;
  if (found.merged) became = merge_neighbours(sums, search.search_radius);

  // Sources in the order of their weight.
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < groups; ++i)
    if (became[i] == i) order.push_back(i);
  std::vector<GlareSource> sources(groups);
  for (const std::size_t i : order) sources[i] = sums[i].source();
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return weight_of(sources[a]) > weight_of(sources[b]); });
  std::vector<std::int32_t> number(groups, 0);
  for (const std::size_t i : order) {
    found.sources.push_back(sources[i]);
    number[i] = static_cast<std::int32_t>(found.sources.size());
  }
  found.source_of_pixel.assign(picture.size(), 0);
  for (std::size_t i = 0; i < picture.size(); ++i)
    if (group_of[i] >= 0) found.source_of_pixel[i] = number[became[static_cast<std::size_t>(group_of[i])]];
  return found;
}

}  // namespace tessera::photometry
