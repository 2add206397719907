// Weights of bidirectional paths, kept along subpaths, against their definition: the density of one way over
// the sum of all, each squared, along random paths.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "render/transport/vertex/light_end.h"
#include "render/transport/vertex/partial_weights.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A point of a path: 0 is on the light, the last the lens.
struct PathPoint {
  Float to_light, to_eye;      // cosines
  Float from_light, from_eye;  // densities by solid angle of going on, from that side
  Float length_squared;        // the edge towards the eye
  bool specular = false;
};

struct RandomPath {
  std::vector<PathPoint> points;
  Float sampled, emitted_place, emitted_direction;  // densities by solid angle, by area, by solid angle
  Float camera;                                     // density by area of the vertex next to the lens
  Float camera_samples;
  bool delta_light;
  float photons = 0;  // photons merged with a vertex, for one that is joined

  RandomPath(int edges, unsigned seed, bool delta) : points(static_cast<std::size_t>(edges) + 1) {
    RandomLanes random(seed);
    for (PathPoint& p : points) {
      p = {random(0.1f), random(0.1f), random(0.1f, 3), random(0.1f, 3), random(0.2f, 4)};
    }
    sampled = random(0.1f, 5);
    emitted_place = random(0.05f, 2);
    emitted_direction = random(0.1f);
    camera = random(0.5f, 50);
    camera_samples = random(1, 40);
    delta_light = delta;
  }
  const PathPoint& operator[](int i) const { return points[static_cast<std::size_t>(i)]; }
  int edges() const { return static_cast<int>(points.size()) - 1; }
  Float light_cosine() const { return delta_light ? Float(1.0f) : points[0].to_eye; }

  /// The end on the light as the product has it. `sampled` is of delta lights the probability of the light.
  LightEnd end() const {
    const Float cosine = light_cosine();
    return {delta_light ? sampled * points[0].length_squared : sampled * cosine,
            emitted_place * emitted_direction, delta_light ? Float(0.0f) : cosine};
  }

  /// Density of the way with `s` vertices from the light, by the book, whatever is joined.
  std::array<double, kWidth> density_if_joined(int s) const {
    std::array<double, kWidth> result;
    const int k = edges();
    for (int l = 0; l < kWidth; ++l) {
      const auto at = [&](const Float& x) { return static_cast<double>(x.lane(l)); };
      double p = 1;
      if (s == 0) {
        p *= delta_light ? 0 : at((*this)[0].to_eye) / at((*this)[0].length_squared);
        if (!(*this)[1].specular) p *= at((*this)[1].from_eye);
      } else if (s == 1) {
        p *= delta_light ? at(sampled) : at(sampled) * at((*this)[0].to_eye) / at((*this)[0].length_squared);
      } else {
        p *= at(emitted_place) * at(emitted_direction) * at((*this)[1].to_light) /
             at((*this)[0].length_squared);
        for (int i = 2; i < s; ++i) {
          if (!(*this)[i - 1].specular) p *= at((*this)[i - 1].from_light);
          p *= at((*this)[i].to_light) / at((*this)[i - 1].length_squared);
        }
      }
      if (s == k) {
        p *= at(camera_samples);
      } else {
        p *= at(camera);
        for (int i = k - 2; i >= std::max(s, 1); --i) {
          if (!(*this)[i + 1].specular) p *= at((*this)[i + 1].from_eye);
          p *= at((*this)[i].to_eye) / at((*this)[i].length_squared);
        }
      }
      result[static_cast<std::size_t>(l)] = p;
    }
    return result;
  }

  /// The same, nothing where mirrors would be joined.
  std::array<double, kWidth> density(int s) const {
    const bool joins = s > 0;
    if (joins && ((*this)[s - 1].specular || (s < edges() && (*this)[s].specular))) return {};
    return density_if_joined(s);
  }
  /// Density with which vertex i is on both subpaths, to be merged.
  std::array<double, kWidth> density_of_merging(int i) const {
    const PathPoint& p = (*this)[i];
    if (p.specular) return {};
    std::array<double, kWidth> result = density_if_joined(i + 1);
    Float from_eye = camera / camera_samples;
    if (i + 1 < edges()) {
      const PathPoint& next = (*this)[i + 1];
      from_eye = (next.specular ? Float(1.0f) : next.from_eye) * p.to_eye / p.length_squared;
    }
    for (int l = 0; l < kWidth; ++l)
      result[static_cast<std::size_t>(l)] *= static_cast<double>(from_eye.lane(l)) * double{photons};
    return result;
  }

  Float merged() const { return power(Float(photons)); }

  /// Sums at vertex i of the subpath from the light.
  PartialWeights from_light(int i) const {
    PartialWeights sums = end().first_vertex((*this)[1].to_light);
    for (int v = 1; v < i; ++v) {
      const PathPoint& p = (*this)[v];
      sums = sums.scattered(p.to_eye, p.from_light, p.from_eye, merged(),
                            p.specular ? Mask::all() : Mask::none());
      sums.arrive(p.length_squared, (*this)[v + 1].to_light);
    }
    return sums;
  }
  /// The same from the eye; `left` before it arrives there.
  PartialWeights from_eye(int i, bool left = false) const {
    PartialWeights sums{power(camera_samples / camera), Float(0.0f)};
    for (int v = edges() - 1; v > i; --v) {
      const PathPoint& p = (*this)[v];
      sums = sums.scattered(p.to_light, p.from_eye, p.from_light, merged(),
                            p.specular ? Mask::all() : Mask::none());
      if (!left || v - 1 > i) sums.arrive((*this)[v - 1].length_squared, (*this)[v - 1].to_eye);
    }
    return sums;
  }

  /// The weight of the way with `s` vertices from the light, as the product computes it.
  Float weight(int s) const {
    const int k = edges();
    if (s == 0) return end().hit_weight(from_eye(0, true));
    if (s == 1) {
      const PathPoint& z = (*this)[1];
      return end().sampling_weight(from_eye(1), z.to_light, z.from_eye, z.from_light, merged());
    }
    const PathPoint& y = (*this)[s - 1];
    if (s == k) {
      return weight_of_way(from_light(s - 1).ways(camera / camera_samples, y.from_eye, merged()),
                           Float(0.0f));
    }
    const PathPoint& z = (*this)[s];
    const Float inverse_square = 1.0f / y.length_squared;
    return weight_of_way(
        from_light(s - 1).ways(z.from_eye * y.to_eye * inverse_square, y.from_eye, merged()),
        from_eye(s).ways(y.from_light * z.to_light * inverse_square, z.from_light, merged()));
  }
};

/// Ways to make a path: one with each number of vertices from the light, then a merge at each vertex.
struct Way {
  std::array<double, kWidth> density;
  Float weight;
};
std::vector<Way> ways_of(const RandomPath& path) {
  std::vector<Way> ways;
  for (int s = 0; s <= path.edges(); ++s) ways.push_back({path.density(s), path.weight(s)});
  if (path.photons == 0) return ways;
  const Float inverse(1 / path.photons);
  for (int i = 1; i < path.edges(); ++i) {
    const PathPoint& p = path[i];
    const Float weight = weight_of_way(path.from_light(i).ways(inverse, p.from_eye, Float(0.0f)),
                                       path.from_eye(i).ways(inverse, p.from_light, Float(0.0f)));
    ways.push_back({path.density_of_merging(i), weight});
  }
  return ways;
}

/// Every way's weight within 1e-4, and their sum: some hundred roundings of 6e-8 each on a path.
void expect_definition(const RandomPath& path) {
  const std::vector<Way> ways = ways_of(path);
  for (std::size_t l = 0; l < kWidth; ++l) {
    double all = 0, sum = 0;
    for (const Way& way : ways) all += way.density[l] * way.density[l];
    ASSERT_GT(all, 0);
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const double p = ways[i].density[l];
      if (p == 0) continue;
      const auto weight = static_cast<double>(ways[i].weight.lane(static_cast<int>(l)));
      EXPECT_NEAR(weight, p * p / all, 1e-4) << "way " << i << " of " << path.edges() << " edges";
      sum += weight;
    }
    EXPECT_NEAR(sum, 1, 1e-4);
  }
}

TEST(PartialWeights, AreTheSquaredDensityOverTheSumOfAll) {
  for (int edges = 2; edges <= 9; ++edges) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      for (const bool delta : {false, true}) {
        RandomPath path(edges, 100 * static_cast<unsigned>(edges) + seed, delta);
        expect_definition(path);
        path.photons = 0.7f;
        expect_definition(path);
      }
    }
  }
}

TEST(PartialWeights, JoinNothingToMirrors) {
  for (int edges = 3; edges <= 8; ++edges) {
    for (int mirror = 1; mirror < edges; ++mirror) {
      for (const bool delta : {false, true}) {
        RandomPath path(edges, static_cast<unsigned>(edges * 10 + mirror), delta);
        path.points[static_cast<std::size_t>(mirror)].specular = true;
        expect_definition(path);
        path.photons = 2;
        expect_definition(path);
        if (mirror + 2 < edges) {
          path.points[static_cast<std::size_t>(mirror) + 2].specular = true;
          expect_definition(path);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
