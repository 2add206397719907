#include "import/pbrt/shapes/subdivision.h"

#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "import/geometry/transform.h"

namespace tessera::client::pbrt {
namespace {

constexpr int kNone = -1;
constexpr int next(int corner) { return (corner + 1) % 3; }
constexpr int previous(int corner) { return (corner + 2) % 3; }

/// `across[k]` is the face on the other side of the edge from corner k to the next.
struct Face {
  std::array<int, 3> v = {kNone, kNone, kNone};
  std::array<int, 3> across = {kNone, kNone, kNone};

  int corner_of(int vertex) const { return v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2; }
};

class LoopMesh {
 public:
  /// False where the faces do not fit one another.
  bool init(const wire::MeshData& control) {
    positions_.resize(control.positions.size() / 3);
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      for (std::size_t a = 0; a < 3; ++a) positions_[i][a] = control.positions[3 * i + a];
    }
    faces_.resize(control.indices.size() / 3);
    for (std::size_t i = 0; i < control.indices.size(); ++i) {
      faces_[i / 3].v[i % 3] = static_cast<int>(control.indices[i]);
    }
    return connect();
  }

  void refine() {
    std::vector<Imath::V3d> positions(positions_.size());
    for (std::size_t i = 0; i < positions_.size(); ++i) positions[i] = moved_vertex(static_cast<int>(i));
    std::vector<Face> faces(4 * faces_.size());
    std::unordered_map<std::uint64_t, int> vertex_of_edge;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const Face& face = faces_[f];
      std::array<int, 3> middle;
      for (int k = 0; k < 3; ++k) {
        const auto [entry, fresh] = vertex_of_edge.try_emplace(undirected(face.v[k], face.v[next(k)]),
                                                               static_cast<int>(positions.size()));
        if (fresh) positions.push_back(edge_vertex(face, k));
        middle[k] = entry->second;
      }
      for (int k = 0; k < 3; ++k) faces[4 * f + k].v = {face.v[k], middle[k], middle[previous(k)]};
      faces[4 * f + 3].v = middle;
    }
    positions_ = std::move(positions);
    faces_ = std::move(faces);
    connect();
  }

  wire::MeshData limit() const {
    wire::MeshData mesh;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      const int vertex = static_cast<int>(i);
      std::vector<Imath::V3d> ring;
      const bool border = one_ring(vertex, ring);
      const Imath::V3d p = ring.empty() ? positions_[i] : limit_position(vertex, ring, border);
      // The tangents of the limit surface, from the ring at this level.
      const Imath::V3d n = ring.empty() ? Imath::V3d{0, 0, 0} : limit_normal(vertex, p, ring, border);
      append_floats(mesh.positions, p);
      append_floats(mesh.normals, n);
    }
    for (const Face& face : faces_) {
      for (const int v : face.v) mesh.indices.push_back(static_cast<std::uint32_t>(v));
    }
    return mesh;
  }

 private:
  static std::uint64_t directed(int a, int b) {
    return (static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint32_t>(b);
  }
  static std::uint64_t undirected(int a, int b) { return a < b ? directed(a, b) : directed(b, a); }

  /// Finds the faces across all edges, and one face of every vertex.
  bool connect() {
    std::unordered_map<std::uint64_t, int> face_of_edge;
    face_of_edge.reserve(3 * faces_.size());
    face_of_vertex_.assign(positions_.size(), kNone);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      for (int k = 0; k < 3; ++k) {
        const int a = faces_[f].v[k], b = faces_[f].v[next(k)];
        face_of_vertex_[static_cast<std::size_t>(a)] = static_cast<int>(f);
        if (a == b || !face_of_edge.try_emplace(directed(a, b), static_cast<int>(f)).second) return false;
      }
    }
    for (Face& face : faces_) {
      for (int k = 0; k < 3; ++k) {
        const auto other = face_of_edge.find(directed(face.v[next(k)], face.v[k]));
        face.across[k] = other == face_of_edge.end() ? kNone : other->second;
      }
    }
    return true;
  }

  const Face& face(int index) const { return faces_[static_cast<std::size_t>(index)]; }
  int face_after(int f, int vertex) const { return face(f).across[face(f).corner_of(vertex)]; }
  int face_before(int f, int vertex) const { return face(f).across[previous(face(f).corner_of(vertex))]; }
  const Imath::V3d& corner_after(int f, int vertex) const {
    return positions_[static_cast<std::size_t>(face(f).v[next(face(f).corner_of(vertex))])];
  }
  const Imath::V3d& corner_before(int f, int vertex) const {
    return positions_[static_cast<std::size_t>(face(f).v[previous(face(f).corner_of(vertex))])];
  }

  /// The neighbours in order; true at a border, where the first and the last lie on it. Empty without faces.
  bool one_ring(int vertex, std::vector<Imath::V3d>& ring) const {
    const int start = face_of_vertex_[static_cast<std::size_t>(vertex)];
    if (start == kNone) return false;
    int f = start;
    do {
      ring.push_back(corner_after(f, vertex));
      const int after = face_after(f, vertex);
      if (after == kNone) break;
      f = after;
    } while (f != start);
    if (face_after(f, vertex) != kNone) return false;
    // A border: once more, from its first face back.
    ring.assign(1, corner_after(f, vertex));
    for (; f != kNone; f = face_before(f, vertex)) ring.push_back(corner_before(f, vertex));
    return true;
  }

  Imath::V3d weighted(int vertex, const std::vector<Imath::V3d>& ring, double weight) const {
    Imath::V3d p =
        (1 - static_cast<double>(ring.size()) * weight) * positions_[static_cast<std::size_t>(vertex)];
    for (const Imath::V3d& q : ring) p = p + weight * q;
    return p;
  }
  Imath::V3d weighted_border(int vertex, const std::vector<Imath::V3d>& ring, double weight) const {
    return (1 - 2 * weight) * positions_[static_cast<std::size_t>(vertex)] +
           weight * (ring.front() + ring.back());
  }
  static double beta(std::size_t valence) {
    return valence == 3 ? 3.0 / 16 : 3.0 / (8.0 * static_cast<double>(valence));
  }

  Imath::V3d moved_vertex(int vertex) const {
    std::vector<Imath::V3d> ring;
    const bool border = one_ring(vertex, ring);
    if (ring.empty()) return positions_[static_cast<std::size_t>(vertex)];
    if (border) return weighted_border(vertex, ring, 1.0 / 8);
    return weighted(vertex, ring, beta(ring.size()));
  }

  Imath::V3d edge_vertex(const Face& face, int k) const {
    const auto at = [&](int v) { return positions_[static_cast<std::size_t>(v)]; };
    const Imath::V3d ends = at(face.v[k]) + at(face.v[next(k)]);
    if (face.across[k] == kNone) return 0.5 * ends;
    const Imath::V3d opposite = corner_before(face.across[k], face.v[next(k)]);
    return 0.375 * ends + 0.125 * (at(face.v[previous(k)]) + opposite);
  }

  Imath::V3d limit_position(int vertex, const std::vector<Imath::V3d>& ring, bool border) const {
    if (border) return weighted_border(vertex, ring, 1.0 / 5);
    const double valence = static_cast<double>(ring.size());
    return weighted(vertex, ring, 1 / (valence + 3 / (8 * beta(ring.size()))));
  }

  /// Not of unit length.
  static Imath::V3d limit_normal(int, const Imath::V3d& p, const std::vector<Imath::V3d>& ring, bool border) {
    constexpr double kPi = std::numbers::pi;
    const std::size_t valence = ring.size();
    Imath::V3d s{0, 0, 0}, t{0, 0, 0};
    if (!border) {
      for (std::size_t j = 0; j < valence; ++j) {
        const double angle = 2 * kPi * static_cast<double>(j) / static_cast<double>(valence);
        s = s + std::cos(angle) * ring[j];
        t = t + std::sin(angle) * ring[j];
      }
      return s.cross(t);
    }
    s = ring.back() - ring.front();
    if (valence == 2) {
      t = ring[0] + ring[1] - 2.0 * p;
    } else if (valence == 3) {
      t = ring[1] - p;
    } else if (valence == 4) {
      t = 2.0 * (ring[1] + ring[2]) - ring[0] - ring[3] - 2.0 * p;
    } else {
      const double theta = kPi / static_cast<double>(valence - 1);
      t = std::sin(theta) * (ring.front() + ring.back());
      for (std::size_t k = 1; k + 1 < valence; ++k) {
        t = t + ((2 * std::cos(theta) - 2) * std::sin(static_cast<double>(k) * theta)) * ring[k];
      }
      t = -1.0 * t;
    }
    return s.cross(t);
  }

  std::vector<Imath::V3d> positions_;
  std::vector<Face> faces_;
  std::vector<int> face_of_vertex_;
};

}  // namespace

std::optional<wire::MeshData> subdivide_loop(const wire::MeshData& control, int levels) {
  LoopMesh mesh;
  if (!mesh.init(control)) return std::nullopt;
  for (int i = 0; i < levels; ++i) mesh.refine();
  return mesh.limit();
}

}  // namespace tessera::client::pbrt
