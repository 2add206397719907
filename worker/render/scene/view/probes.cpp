#include "render/scene/view/probes.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/values/located.h"
#include "render/sensor/probe_table.h"
#include "tessera/v1/job.pb.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

namespace {

using Imath::V3d;

absl::Status fault(const std::string& what) { return absl::InvalidArgumentError(what); }

V3d vector_of(const v1::Point3& p) { return {p.x(), p.y(), p.z()}; }
bool is_finite(const V3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
void keep(const V3d& v, float (&out)[3]) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}

/// Any unit vector at right angles to a unit vector.
V3d across(const V3d& axis) {
  const V3d other = std::abs(axis.x) < 0.5 ? V3d(1, 0, 0) : V3d(0, 1, 0);
  return (other - axis * (other ^ axis)).normalized();
}

bool has_own_normals(const v1::Probe& probe) { return probe.has_mesh() || probe.has_sphere(); }

absl::Status set_axes(const v1::Probe& probe, ProbeRecord& record) {
  if (has_own_normals(probe)) {
    if (probe.kind() == v1::Probe::HALF_CYLINDER)
      return fault("half of a cylinder has one front: it is no reading of surfaces whose normals differ");
    return absl::OkStatus();
  }
  V3d axis = vector_of(probe.axis());
  if (!is_finite(axis) || !(axis.length() > 0)) return fault("its axis has no direction");
  axis.normalize();
  V3d front = across(axis);
  if (probe.has_front()) {
    front = vector_of(probe.front());
    front -= axis * (front ^ axis);
    if (!is_finite(front) || !(front.length() > 1e-6 * vector_of(probe.front()).length()))
      return fault("its front has no direction at right angles to the axis");
    front.normalize();
  } else if (probe.kind() == v1::Probe::HALF_CYLINDER) {
    return fault("half of a cylinder needs a front");
  }
  keep(axis, record.axis), keep(front, record.front);
  return absl::OkStatus();
}

/// Blobs, of which the one that was read last is kept: the probes of a surface's triangles share theirs.
class MeshBlobs {
 public:
  explicit MeshBlobs(const BlobSource* source) : source_(source) {}

  bool are_there() const { return source_ != nullptr && *source_; }
  absl::StatusOr<std::string_view> bytes(const std::string& digest) {
    if (digest == digest_) return last_.bytes;
    auto bytes = (*source_)(digest);
    if (!bytes.ok()) return bytes.status();
    digest_ = digest, last_ = *std::move(bytes);
    return last_.bytes;
  }

 private:
  const BlobSource* source_;
  std::string digest_;
  BlobBytes last_;
};

absl::Status add_triangles(const v1::ProbeMesh& mesh, const RenderSpace& space, MeshBlobs& blobs,
                           ProbeRecord& record, ProbeTable& table) {
  const auto world_from_mesh = Transform::from_proto(mesh.world_from_mesh());
  if (!world_from_mesh.ok()) return world_from_mesh.status();
  const auto bytes = blobs.bytes(mesh.mesh().digest());
  if (!bytes.ok()) return bytes.status();
  const auto view = wire::decode_mesh(*bytes);
  if (!view.ok()) return view.status();
  const Transform to_render = space.from_world * *world_from_mesh;
  const bool mirrors = world_from_mesh->determinant() < 0;
  record.first_triangle = static_cast<std::int32_t>(table.area_before_triangle.size());
  const auto corner = [&](std::uint32_t vertex) {
    const float* const p = view->positions.data() + std::size_t{3} * vertex;
    return to_render.apply({p[0], p[1], p[2]});
  };
  std::vector<double> before;
  double area = 0;
  for (std::size_t t = 0; t < view->triangle_count(); ++t) {
    const std::uint32_t* const index = view->indices.data() + 3 * t;
    const V3d a = corner(index[0]);
    V3d e1 = corner(index[1]) - a, e2 = corner(index[2]) - a;
    if (mirrors) std::swap(e1, e2);
    const double part = (e1 % e2).length() / 2;
    if (!(part > 0)) continue;
    before.push_back(area);
    area += part;
    for (const V3d& v : {a, e1, e2})
      for (int i = 0; i < 3; ++i) table.triangles.push_back(static_cast<float>(v[i]));
  }
  if (!(area > 0) || !std::isfinite(area)) return fault("its mesh has no area");
  for (const double part : before) table.area_before_triangle.push_back(static_cast<float>(part / area));
  record.last_triangle = static_cast<std::int32_t>(table.area_before_triangle.size());
  return absl::OkStatus();
}

/// The number of cells.
absl::StatusOr<std::uint64_t> set_place(const v1::Probe& probe, const RenderSpace& space, MeshBlobs& blobs,
                                        ProbeRecord& record, ProbeTable& table) {
  const auto place = [&](const v1::Point3& p, float(&out)[3]) {
    const V3d in_render_space = space.from_world.apply(vector_of(p));
    keep(in_render_space, out);
    return is_finite(in_render_space);
  };
  const auto set_round = [&](ProbePlace shape, const auto& round) {
    record.place = shape;
    record.radius = static_cast<float>(round.radius());
    return place(round.middle(), record.origin) && record.radius > 0 && std::isfinite(record.radius);
  };
  record.side = probe.inward() ? -1.0f : 1.0f;
  switch (probe.place_case()) {
    case v1::Probe::kPoint:
      record.place = ProbePlace::kPoint;
      if (!place(probe.point(), record.origin)) return fault("its point is not finite");
      return 1;
    case v1::Probe::kPlane: {
      const v1::ProbePlane& plane = probe.plane();
      const std::uint32_t columns = std::max(1u, plane.columns()), rows = std::max(1u, plane.rows());
      record.place = ProbePlace::kPlane;
      record.at_middles = plane.at_middles();
      const V3d u = vector_of(plane.edge_u()) / columns, v = vector_of(plane.edge_v()) / rows;
      if (!place(plane.corner(), record.origin) || !is_finite(u) || !is_finite(v) || !((u % v).length() > 0))
        return fault("its plane has no area");
      keep(u, record.edge_u), keep(v, record.edge_v);
      return std::uint64_t{columns} * rows;
    }
    case v1::Probe::kMesh: {
      record.place = ProbePlace::kMesh;
      if (!blobs.are_there()) return 1;
      if (auto s = add_triangles(probe.mesh(), space, blobs, record, table); !s.ok()) return s;
      return 1;
    }
    case v1::Probe::kDisk:
      if (!set_round(ProbePlace::kDisk, probe.disk())) return fault("its disk has no area");
      return 1;
    case v1::Probe::kSphere:
      if (!set_round(ProbePlace::kSphere, probe.sphere())) return fault("its sphere has no area");
      return 1;
    case v1::Probe::PLACE_NOT_SET:
      break;
  }
  return fault("it has no place");
}

/// Whether all light is found by joining vertices of paths from lights to probes.
bool joins_probes(const wire::AlgorithmTraits& algorithm) {
  return algorithm.starts_at_lights && algorithm.blindness == wire::Blindness::kMirrorImages;
}

absl::Status set_kind(const v1::Probe& probe, const wire::AlgorithmTraits& algorithm, ProbeRecord& record) {
  record.kind = static_cast<ProbeKind>(probe.kind());
  if (!v1::Probe::Kind_IsValid(probe.kind())) return fault("its kind is unknown");
  if (probe.kind() == v1::Probe::CONE) {
    if (!(probe.field_degrees() >= 0 && probe.field_degrees() <= 360))
      return fault(absl::StrCat("a cone of ", probe.field_degrees(), " degrees is not in [0, 360]"));
    record.one_minus_cos =
        static_cast<float>(2 * std::pow(std::sin(probe.field_degrees() * std::numbers::pi / 720), 2));
  }
  if (probe.kind() == v1::Probe::FAR_FIELD && !probe.has_disk())
    return fault("what is far away is read over a disk");
  if (probe.kind() == v1::Probe::EXITANCE && !(probe.offset() > 0))
    return fault("what leaves a surface is read from an offset above 0");
  if (!(probe.offset() >= 0) || !std::isfinite(probe.offset())) return fault("its offset is below 0");
  record.offset = static_cast<float>(probe.offset());
  if (joins_probes(algorithm) && !connects(record))
    return fault(
        absl::StrCat("integrator '", algorithm.name,
                     "' joins points of the scene to probes, which cannot be done where a probe reads "
                     "a single ray or what leaves a surface; 'path' does"));
  return absl::OkStatus();
}

/// Gives the next pixels to a probe's cells.
absl::Status set_pixels(const v1::Probe& probe, std::uint64_t cells, std::size_t film_pixels,
                        ProbeTable& table) {
  if (probe.pixels_of_cells_size() > 0 && static_cast<std::uint64_t>(probe.pixels_of_cells_size()) != cells)
    return fault(
        absl::StrCat("it has ", cells, " cells, and numbers of pixels for ", probe.pixels_of_cells_size()));
  const std::uint32_t columns = probe.has_plane() ? std::max(1u, probe.plane().columns()) : 1;
  const auto number = static_cast<std::int32_t>(table.probes.size()) - 1;
  for (std::uint64_t cell = 0; cell < cells; ++cell) {
    const std::uint32_t pixels = probe.pixels_of_cells_size() > 0
                                     ? probe.pixels_of_cells(static_cast<int>(cell))
                                     : std::max(1u, probe.pixels());
    if (pixels > film_pixels - table.probe_of_pixel.size())
      return fault(absl::StrCat("its cells have more pixels than the film's ", film_pixels));
    table.probe_of_pixel.insert(table.probe_of_pixel.end(), pixels, number);
    const std::uint64_t column = cell % columns, row = cell / columns;
    table.column_of_pixel.insert(table.column_of_pixel.end(), pixels, static_cast<float>(column));
    table.row_of_pixel.insert(table.row_of_pixel.end(), pixels, static_cast<float>(row));
  }
  return absl::OkStatus();
}

absl::Status check_camera_of_probes(const v1::Camera& camera, const wire::AlgorithmTraits& algorithm) {
  if (!algorithm.reads_probes)
    return fault(absl::StrCat("camera: integrator '", algorithm.name,
                              "' does not read probes; path, volpath, direct, light and bdpt do"));
  if (camera.motion_size() > 0 || camera.has_world_from_camera_end() || camera.has_viewpoint() ||
      camera.has_distortion() || camera.has_focus_point() || camera.screen_window_size() > 0 ||
      camera.world_from_camera().elements_size() > 0)
    return fault(
        "camera: the places of probes are of world space: no transform, motion, viewpoint, distortion, "
        "focus or screen window goes with them");
  return absl::OkStatus();
}

}  // namespace

absl::Status set_probes(const v1::Camera& camera, const RenderSpace& space,
                        const wire::AlgorithmTraits& algorithm, const BlobSource* blobs,
                        SensorRecord& record) {
  if (auto s = check_camera_of_probes(camera, algorithm); !s.ok()) return s;
  const auto film_pixels = static_cast<std::size_t>(record.width) * static_cast<std::size_t>(record.height);
  auto table = std::make_shared<ProbeTable>();
  MeshBlobs meshes(blobs);
  for (int i = 0; i < camera.probes().probes_size(); ++i) {
    const v1::Probe& probe = camera.probes().probes(i);
    ProbeRecord& added = table->probes.emplace_back();
    const auto set = [&]() -> absl::Status {
      if (auto s = set_axes(probe, added); !s.ok()) return s;
      if (auto s = set_kind(probe, algorithm, added); !s.ok()) return s;
      const auto cells = set_place(probe, space, meshes, added, *table);
      if (!cells.ok()) return cells.status();
      return set_pixels(probe, *cells, film_pixels, *table);
    };
    if (auto s = set(); !s.ok()) return located(s, absl::StrCat("camera: probe ", i + 1));
  }
  if (table->probes.empty()) return fault("camera: it has no probes");
  table->pixels = static_cast<std::int32_t>(table->probe_of_pixel.size());
  table->probe_of_pixel.resize(film_pixels, -1);
  table->column_of_pixel.resize(film_pixels), table->row_of_pixel.resize(film_pixels);
  // Algorithms of two ends leave joins to probes out: they would be to pixels by chance, far from all others.
  record.kind = joins_probes(algorithm) ? SensorKind::kConnectingProbes : SensorKind::kProbes;
  record.render_from_sensor = Affine{};
  record.probes = std::move(table);
  return absl::OkStatus();
}

absl::Status check_probe_film(const v1::PixelFilter& filter, const v1::JobSpec& job) {
  const auto is_narrow = [](float radius) { return radius > 0 && radius <= kProbeFilterRadius; };
  if (filter.kind() != v1::PixelFilter::BOX || !is_narrow(filter.radius_x()) || !is_narrow(filter.radius_y()))
    return fault(
        absl::StrCat("readings of probes are pixels of their own: the filter has to be a box of radius ",
                     kProbeFilterRadius));
  const v1::PathSharing sharing = job.view().path_sharing();
  if (sharing != v1::PATH_SHARING_OFF && sharing != v1::PATH_SHARING_UNSPECIFIED)
    return fault("readings of probes are independent: path_sharing has to be off");
  return absl::OkStatus();
}

}  // namespace tessera::render
