#include "render/textbook/radiosity/links.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

/// Pairs that are looked at together: findings take 400 bytes each.
constexpr std::size_t kPairsALook = 4096;

/// Rays from a point to a light that is not a point itself.
constexpr int kRaysToSky = 2 * kWidth;

float largest(const Colour& light) { return *std::max_element(std::begin(light.band), std::end(light.band)); }

std::uint64_t key_of(Name receiver, Name source, std::int32_t light) {
  return receiver.bits() * 0x9e3779b97f4a7c15u ^ (light < 0 ? source.bits() : ~std::uint64_t(light));
}

/// An upper bound of the form factor from any point of the receiver to a cluster; 1 where they are too near
/// to each other to tell.
double largest_factor(const Patch& receiver, const Cluster& source) {
  const double near = length(source.centre - receiver.centre()) - receiver.radius();
  if (!(near > 1.5 * source.radius)) return 1;
  // The sphere about the cluster, and its area if all of it were turned to the receiver.
  const double sphere = source.radius * source.radius / (near * near);
  const double rest = near - source.radius;
  return std::min(sphere, source.area / (std::numbers::pi * rest * rest));
}

/// Evenly over the third of a triangle that is nearest to a corner, of numbers in [0, 1): a shadow that
/// misses a point or two of a large patch is met.
Weights near_corner(int corner, double u, double v) {
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const double w[3] = {1 - u - v, u, v};
  const std::ptrdiff_t largest = std::max_element(w, w + 3) - w;
  Weights at;
  for (std::ptrdiff_t i = 0; i < 3; ++i)
    at.w[static_cast<std::size_t>((corner + i) % 3)] = w[(largest + i) % 3];
  return at;
}

/// Values that a blob may have: lights of a scene may add up to anything.
Colour bounded(Colour light) {
  for (float& value : light.band) value = value > 0 ? std::min(value, std::numeric_limits<float>::max()) : 0;
  return light;
}

}  // namespace

void pull(const Surfaces& surfaces, const Clusters& clusters, Brightness& brightness) {
  brightness.clusters.assign(clusters.all().size(), {});
  for (std::size_t i = clusters.all().size(); i-- > 0;) {
    const Cluster& cluster = clusters.all()[i];
    if (cluster.count == 1) {
      brightness.clusters[i] = brightness.sides[clusters.only_side(cluster)];
      continue;
    }
    Brightness::Value& mean = brightness.clusters[i];
    for (const std::uint32_t child : cluster.children) {
      const auto share = static_cast<float>(clusters.all()[child].area / cluster.area);
      mean.whole += share * brightness.clusters[child].whole;
      mean.emitted += share * brightness.clusters[child].emitted;
    }
  }
}

double Linker::Finding::factor(int point) const {
  const float rays = sent[point].band[0];
  return rays > 0 ? view.factor[point] * double{arrives[point].band[0]} / double{rays} : 0;
}

bool Linker::Finding::partly_hidden() const {
  float reached = 0, all = 0;
  for (int i = 0; i < kPoints; ++i) reached += largest(arrives[i]), all += largest(sent[i]);
  return reached > 0 && reached < all;
}

Linker::Linker(const IntegratorContext& context, const Surfaces& surfaces, const Clusters& clusters,
               const Brightness& brightness, const LinkBounds& bounds)
    : context_(context),
      surfaces_(surfaces),
      clusters_(clusters),
      brightness_(brightness),
      bounds_(bounds),
      visibility_(context) {
  const LightTable& lights = context.scene.lights;
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    if (lights.lights[i].shape < 0) lights_without_surface_.push_back(static_cast<std::int32_t>(i));
  }
}

void Linker::link(Side side, Links& to) {
  if (!(surfaces_.area(side) > 0)) return;
  const Name name = Name::of_side(side);
  std::vector<Pair> pairs{{name, Name::of_cluster(0)}}, asked, next;
  for (const std::int32_t light : lights_without_surface_) pairs.push_back({name, {}, light});
  const std::size_t first = to.links.size();
  const double most = bounds_.links_per_side + bounds_.links_per_area * surfaces_.area(side);
  std::size_t decided = 0;  // pairs of lights
  lit_.clear();
  std::vector<Finding> findings;
  bool cut_short = false;
  while (!pairs.empty()) {
    next.clear(), asked.clear();
    // A split takes one pair away and adds four at most. Lights count with what they are split into: those
    // that are decided at one patch are one.
    std::size_t count = to.links.size() - first + decided + pairs.size() - lights_without_surface_.size();
    const auto has_room = [&] {
      if (static_cast<double>(count + 3) <= most) return true;
      cut_short = true;
      return false;
    };
    const auto split_up = [&](const Pair& pair, Decision decision) {
      split(pair, decision, next);
      count += 3;
    };
    for (const Pair& pair : pairs) {
      const Decision decision = before_rays(pair);
      if (decision == Decision::kSplitSource && has_room()) {
        split_up(pair, decision);
      } else if (decision != Decision::kDrop) {
        asked.push_back(pair);
      }
    }
    for (std::size_t begin = 0; begin < asked.size(); begin += kPairsALook) {
      const auto look = std::span(asked).subspan(begin, std::min(kPairsALook, asked.size() - begin));
      examine(look, findings);
      for (std::size_t i = 0; i < look.size(); ++i) {
        const Decision decision = after_rays(look[i], findings[i]);
        if (decision == Decision::kDrop) continue;
        if (decision != Decision::kLink && has_room()) {
          split_up(look[i], decision);
        } else {
          append(look[i], findings[i], to);
          decided += look[i].light >= 0;
        }
      }
    }
    pairs.swap(next);
  }
  to.cut_short += cut_short;
}

void Linker::split(const Pair& pair, Decision decision, std::vector<Pair>& to) const {
  if (decision == Decision::kSplitReceiver) {
    for (unsigned i = 0; i < 4; ++i) to.push_back({pair.receiver.part(i), pair.source, pair.light});
  } else if (!pair.source.is_cluster()) {
    for (unsigned i = 0; i < 4; ++i) to.push_back({pair.receiver, pair.source.part(i)});
  } else {
    const bool one = clusters_.all()[pair.source.cluster()].count == 1;
    for (int i = 0; i < (one ? 1 : 2); ++i)
      to.push_back({pair.receiver, clusters_.child(pair.source.cluster(), i)});
  }
}

void Linker::append(const Pair& pair, const Finding& finding, Links& to) {
  if (pair.light >= 0) {
    Colour sum;
    for (const Colour& irradiance : finding.arrives) sum += irradiance * (1.0f / kPoints);
    if (!(largest(sum) > 0)) return;
    const auto [known, is_new] = lit_.try_emplace(pair.receiver.bits(), to.direct.size());
    if (is_new) to.direct.push_back({pair.receiver, {}});
    DirectLight& light = to.direct[known->second];
    light.irradiance = bounded(light.irradiance + sum);
    ++light.lights;
    return;
  }
  double factor = 0;
  for (int i = 0; i < kPoints; ++i)
    factor += (pair.source.is_cluster() ? double{finding.arrives[i].band[0]} : finding.factor(i)) / kPoints;
  if (factor > 0) to.links.push_back({pair.receiver, pair.source, std::min(factor, 1.0)});
}

bool Linker::can_split(Name patch) const {
  return bounds_.split && patch.level() < Name::kDeepest &&
         surfaces_.area(patch.side()) > bounds_.smallest_area * std::exp2(2 * patch.level());
}

Linker::Decision Linker::before_rays(const Pair& pair) const {
  if (pair.light >= 0 || !pair.source.is_cluster()) return Decision::kExamine;
  const Patch receiver = surfaces_.patch(pair.receiver);
  const Cluster& source = clusters_.all()[pair.source.cluster()];
  const double height = dot(source.centre - receiver.corner[0], receiver.normal);
  if (height < -source.radius) return Decision::kDrop;
  if (source.count == 1) return Decision::kSplitSource;
  const double factor = largest_factor(receiver, source);
  const Brightness::Value light = brightness_.of(pair.source);
  const bool is_fine = factor <= bounds_.factor && factor * double{light.whole} <= bounds_.error;
  return is_fine ? Decision::kExamine : Decision::kSplitSource;
}

Linker::Decision Linker::after_rays(const Pair& pair, const Finding& finding) const {
  if (pair.light >= 0) return light_after_rays(pair, finding);
  return pair.source.is_cluster() ? Decision::kLink : patch_after_rays(pair, finding);
}

Linker::Decision Linker::patch_after_rays(const Pair& pair, const Finding& finding) const {
  const double most = finding.view.largest();
  if (!(most > 0)) return Decision::kDrop;
  const Brightness::Value light = brightness_.of(pair.source);
  if (!bounds_.split || most * double{light.whole} <= bounds_.relative_error * bounds_.error)
    return Decision::kLink;

  // Parts of the receiver see the source differently; parts of the source shine differently, by half of what
  // they reflect, or something is before some of them. What the receiver's parts see of the many parts of one
  // wall differs alike, and adds up: so it is bounded relative to the link's light, too.
  const double relative =
      bounds_.error / bounds_.relative_error / std::max(most * double{light.whole}, 1e-300);
  const double over_receiver = double{light.whole} * finding.view.spread() * std::max(1.0, relative);
  const double over_source = 0.5 * most * double{light.whole - light.emitted};
  const double hidden = finding.partly_hidden() ? most * double{light.whole} : 0;
  if (std::max({over_receiver, over_source, hidden}) <= bounds_.error) return Decision::kLink;
  bool split_receiver = over_receiver >= over_source;
  if (hidden > std::max(over_receiver, over_source)) {
    const auto area = [&](Name patch) {
      return surfaces_.area(patch.side()) * std::exp2(-2 * patch.level());
    };
    split_receiver = area(pair.receiver) >= area(pair.source);
  }
  const bool receiver = can_split(pair.receiver), source = can_split(pair.source);
  if (!receiver && !source) return Decision::kLink;
  if (split_receiver && !receiver && hidden <= bounds_.error) return Decision::kLink;
  if (!split_receiver && !source && std::max(over_receiver, hidden) <= bounds_.error) return Decision::kLink;
  return (split_receiver && receiver) || !source ? Decision::kSplitReceiver : Decision::kSplitSource;
}

Linker::Decision Linker::light_after_rays(const Pair& pair, const Finding& finding) const {
  float low = INFINITY, high = 0, sum = 0;
  for (const Colour& irradiance : finding.arrives) {
    low = std::min(low, largest(irradiance));
    high = std::max(high, largest(irradiance));
    sum += largest(irradiance);
  }
  if (!can_split(pair.receiver)) return Decision::kLink;
  // Skies are hidden in part almost everywhere, and what rays find of them is noisy: by a quarter, if only
  // some of them are free.
  const std::vector<std::int32_t>& skies = context_.scene.lights.infinite_lights;
  const bool is_sky = std::find(skies.begin(), skies.end(), pair.light) != skies.end();
  const double noise = is_sky ? 0.25 * double{sum} / kPoints : 0;
  const double change = double{high - low};
  const bool hidden = !is_sky && finding.partly_hidden() && double{high} > bounds_.error;
  return hidden || change > std::max(bounds_.error, noise) ? Decision::kSplitReceiver : Decision::kLink;
}

void Linker::examine(std::span<const Pair> pairs, std::vector<Finding>& findings) {
  findings.assign(pairs.size(), {});
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (visibility_.size() + kPoints * kRaysToSky > Visibility::kMost) trace(findings);
    const Pair& pair = pairs[i];
    const Patch receiver = surfaces_.patch(pair.receiver);
    if (pair.light >= 0) {
      aim_at_light(pair, receiver, i);
    } else if (pair.source.is_cluster()) {
      aim_at_cluster(pair, receiver, i);
    } else {
      aim_at_patch(pair, receiver, i, findings[i]);
    }
  }
  trace(findings);
}

void Linker::aim_at_patch(const Pair& pair, const Patch& receiver, std::size_t index, Finding& finding) {
  const Patch source = surfaces_.patch(pair.source);
  finding.view = view(receiver, source);
  Spread spread(key_of(pair.receiver, pair.source, -1));
  for (int point = 0; point < kPoints; ++point) {
    if (!(finding.view.factor[point] > 0)) continue;
    const Vec from = receiver.point(kPoint[point]);
    for (int i = 0; i < bounds_.rays; ++i, spread.next()) {
      const Vec to = finding.view.seen[point].point(spread.u(), spread.v());
      visibility_.add(from, receiver.normal, to, source.normal);
      visibility_rays_.push_back({index, point, {{1, 1, 1}}});
    }
  }
}

void Linker::aim_at_cluster(const Pair& pair, const Patch& receiver, std::size_t index) {
  const Cluster& source = clusters_.all()[pair.source.cluster()];
  Spread spread(key_of(pair.receiver, pair.source, -1));
  for (int point = 0; point < kPoints; ++point) {
    const Vec from = receiver.point(kPoint[point]);
    for (int i = 0; i < bounds_.rays; ++i, spread.next()) {
      double u = spread.u();
      const Patch side = surfaces_.patch(Name::of_side(clusters_.side_at(source, u)));
      const Polygon whole{{side.corner[0], side.corner[1], side.corner[2]}, 3};
      const Vec to = whole.point(u, spread.v()), way = to - from;
      const double cosines = dot(way, receiver.normal) * -dot(way, side.normal), square = dot(way, way);
      if (!(dot(way, receiver.normal) > 0 && cosines > 0)) continue;
      visibility_.add(from, receiver.normal, to, side.normal);
      const auto part =
          static_cast<float>(source.area * cosines / (std::numbers::pi * square * square * bounds_.rays));
      visibility_rays_.push_back({index, point, {{part, part, part}}});
    }
  }
}

void Linker::aim_at_light(const Pair& pair, const Patch& receiver, std::size_t index) {
  const SceneTables& scene = context_.scene;
  const Vec& n = receiver.normal;
  const Vec3 normal{Float(static_cast<float>(n[0])), Float(static_cast<float>(n[1])),
                    Float(static_cast<float>(n[2]))};
  const LightTraits& traits =
      light_model(scene.lights.lights[static_cast<std::size_t>(pair.light)].kind).traits;
  const std::uint64_t key = key_of(pair.receiver, pair.source, pair.light);
  Spread spread(key), places(~key);
  for (int point = 0; point < kPoints; ++point) {
    for (int packet = 0; packet < kRaysToSky / kWidth; ++packet) {
      Vec from[kWidth];
      alignas(64) float p[3][kWidth], u[kWidth], v[kWidth];
      for (int i = 0; i < kWidth; ++i, spread.next(), places.next()) {
        from[i] = receiver.point(near_corner(point, places.u(), places.v()));
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis][i] = static_cast<float>(from[i][axis]);
        u[i] = static_cast<float>(0x1p-24 * std::floor(spread.u() * 0x1p24)),
        v[i] = static_cast<float>(0x1p-24 * std::floor(spread.v() * 0x1p24));
      }
      const LightSample sample = sample_light(
          scene.lights, Int(pair.light), {{Float::load(p[0]), Float::load(p[1]), Float::load(p[2])}, normal},
          {Float::load(u), Float::load(v)}, Mask::all());
      // All samples of a light at a point, or that shines in one direction, are the same.
      const bool is_one = traits.delta && !traits.extended;
      const float share = is_one ? 1.0f / kWidth : 1.0f / kRaysToSky;
      const Float cosine = dot(sample.wi, normal);
      const Mask shines = sample.valid & (cosine > 0.0f);
      alignas(64) float w[3][kWidth], distance[kWidth], band[kBands][kWidth];
      sample.wi.x.store(w[0]), sample.wi.y.store(w[1]), sample.wi.z.store(w[2]);
      sample.distance.store(distance);
      const Float scale = share * cosine / select(shines, sample.pdf, 1.0f);
      for (int b = 0; b < kBands; ++b) (sample.radiance.c[b] * scale).store(band[b]);
      for (int i = 0; i < kWidth; ++i) {
        if ((shines.bits() >> i & 1) == 0) continue;
        visibility_.add(from[i], n, Vec{w[0][i], w[1][i], w[2][i]}, double{distance[i]});
        visibility_rays_.push_back({index, point, {{band[0][i], band[1][i], band[2][i]}}});
      }
      if (is_one) break;
    }
  }
}

void Linker::trace(std::vector<Finding>& findings) {
  visibility_.trace();
  for (int i = 0; i < visibility_.size(); ++i) {
    const Ray& ray = visibility_rays_[static_cast<std::size_t>(i)];
    Finding& finding = findings[ray.finding];
    finding.sent[ray.point] += ray.carries;
    if (visibility_.is_free(i)) finding.arrives[ray.point] += ray.carries;
  }
  visibility_.clear();
  visibility_rays_.clear();
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
