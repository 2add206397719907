#include "local/geometry_query.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "local/scene_blobs.h"
#include "render/scene/load_query.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {
namespace {

constexpr const char* kAnswerColumns[] = {"query",     "kind",     "row",    "shape",   "name",   "instance",
                                          "primitive", "material", "t",      "x",       "y",      "z",
                                          "nx",        "ny",       "nz",     "u",       "v",      "side",
                                          "interior",  "exterior", "parity", "winding", "closed", "error"};
enum Answer : std::size_t {
  kQuery,
  kKind,
  kRow,
  kShape,
  kName,
  kInstance,
  kPrimitive,
  kMaterial,
  kT,
  kX,
  kY,
  kZ,
  kNx,
  kNy,
  kNz,
  kU,
  kV,
  kSide,
  kInterior,
  kExterior,
  kParity,
  kWinding,
  kClosed,
  kError
};
static_assert(std::size(kAnswerColumns) == kError + 1);

constexpr const char* kBoundsColumns[] = {"shape",  "name",   "instance", "low_x", "low_y",    "low_z",
                                          "high_x", "high_y", "high_z",   "tight", "unbounded"};
constexpr const char* kWatertightColumns[] = {
    "shape", "name",      "closed", "triangles", "vertices", "edges", "defects", "defect",
    "faces", "primitive", "from_x", "from_y",    "from_z",   "to_x",  "to_y",    "to_z"};

Cell yes_or_no(bool yes) { return std::string_view(yes ? "yes" : "no"); }
Cell integer(std::int64_t i) { return i; }
Cell text(std::string_view t) { return t.empty() ? Cell{} : Cell{t}; }
Cell single(double x) { return static_cast<float>(x); }
render::V3d vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

void put_shape(const render::QueryScene& scene, std::int32_t shape, std::int32_t instance, Row& row) {
  const render::ShapeNames& names = scene.names(shape);
  row[kShape] = integer(names.number);
  row[kName] = text(names.name);
  if (instance >= 0 && scene.instance_number(instance) > 0)
    row[kInstance] = integer(scene.instance_number(instance));
  row[kMaterial] = text(names.material);
  row[kInterior] = text(names.interior_medium);
  row[kExterior] = text(names.exterior_medium);
}

void put_hit(const render::QueryScene& scene, const render::SurfaceHit& hit, Row& row) {
  put_shape(scene, hit.shape, hit.instance, row);
  row[kPrimitive] = integer(hit.primitive);
  row[kT] = hit.t;
  for (int k = 0; k < 3; ++k) {
    row[static_cast<std::size_t>(kX + k)] = hit.p[k];
    row[static_cast<std::size_t>(kNx + k)] = single(hit.normal[k]);
  }
  row[kU] = single(hit.u), row[kV] = single(hit.v);
}

const char* word_of(QueryKind kind) {
  switch (kind) {
    case QueryKind::kRay:
      return "ray";
    case QueryKind::kInside:
      return "inside";
    case QueryKind::kClosest:
      return "closest";
  }
  return "";
}

const char* word_of(render::Inside inside) {
  switch (inside) {
    case render::Inside::kInside:
      return "inside";
    case render::Inside::kOutside:
      return "outside";
    case render::Inside::kUnsure:
      return "unsure";
  }
  return "";
}

}  // namespace

GeometryQuery::GeometryQuery(std::unique_ptr<const render::QueryScene> scene) : scene_(std::move(scene)) {}
GeometryQuery::~GeometryQuery() = default;

Columns GeometryQuery::answer_columns() { return kAnswerColumns; }
Columns GeometryQuery::bounds_columns() { return kBoundsColumns; }
Columns GeometryQuery::watertight_columns() { return kWatertightColumns; }

absl::StatusOr<std::unique_ptr<GeometryQuery>> GeometryQuery::load(const v1::JobSpec& spec,
                                                                   const std::vector<const SceneBlob*>& blobs,
                                                                   const GeometryOptions& options) {
  const SceneBlobs source(blobs);
  const absl::StatusOr<render::BlobBytes> bytes = source.bytes(spec.content().scene());
  if (!bytes.ok()) return bytes.status();
  v1::Scene message;
  if (!message.ParseFromArray(bytes->bytes.data(), static_cast<int>(bytes->bytes.size())))
    return absl::InternalError("the scene's own message cannot be read");
  if (options.origin) {
    v1::Point3& origin = *message.mutable_render_origin();
    origin.set_x((*options.origin)[0]), origin.set_y((*options.origin)[1]),
        origin.set_z((*options.origin)[2]);
  }
  std::vector<std::string> warnings;
  auto scene = render::load_query(
      message, spec, [&](const std::string& digest) { return source.bytes(digest); },
      {.isa = spec.farm().isa(),
       .time = static_cast<float>(options.shutter_time),
       .threads = options.threads},
      warnings);
  if (!scene.ok()) return scene.status();
  std::unique_ptr<GeometryQuery> self(new GeometryQuery(*std::move(scene)));
  self->warnings_ = std::move(warnings);
  return self;
}

std::string GeometryQuery::doubts(bool closest) const {
  if (!closest) return "";
  const std::vector<std::int32_t> shapes = scene_->without_closest();
  if (shapes.empty()) return "";
  const render::ShapeNames& first = scene_->names(shapes.front());
  return absl::StrCat(
      "shape ", first.number, first.name.empty() ? "" : absl::StrCat(" (", first.name, ")"),
      shapes.size() > 1 ? absl::StrCat(" and ", shapes.size() - 1, " more") : "",
      ": there is no formula for the closest point; column 'error' says by how much it may be "
      "closer than the answer");
}

void GeometryQuery::answer(std::span<const std::optional<Query>> queries, std::int64_t number,
                           const TakeRow& take) const {
  std::vector<render::QueryScene::Line> lines;
  for (const std::optional<Query>& query : queries) {
    if (query && query->kind == QueryKind::kRay)
      lines.push_back({vector_of(query->point), vector_of(query->direction)});
  }
  const std::vector<std::vector<render::SurfaceHit>> hits = scene_->hits(lines);
  auto next = hits.begin();
  for (const std::optional<Query>& query : queries) {
    Row row(std::size(kAnswerColumns));
    row[kQuery] = number++;
    if (!query) continue;
    row[kKind] = std::string_view(word_of(query->kind));
    row[kRow] = integer(0);
    switch (query->kind) {
      case QueryKind::kRay:
        answer_ray(*next++, row, take);
        break;
      case QueryKind::kInside:
        answer_inside(*query, row, take);
        break;
      case QueryKind::kClosest:
        answer_closest(*query, row, take);
        break;
    }
  }
}

void GeometryQuery::answer_ray(const std::vector<render::SurfaceHit>& hits, Row& row,
                               const TakeRow& take) const {
  if (hits.empty()) return take(row);
  const Row empty = row;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    row = empty;
    row[kRow] = integer(static_cast<std::int64_t>(i) + 1);
    put_hit(*scene_, hits[i], row);
    row[kSide] = std::string_view(hits[i].from_front ? "entering" : "leaving");
    take(row);
  }
}

void GeometryQuery::answer_inside(const Query& query, Row& row, const TakeRow& take) const {
  const render::PointReport report = scene_->at(vector_of(query.point));
  const Row empty = row;
  std::int64_t by_parity = 0, by_winding = 0;
  const render::Containment* innermost = nullptr;
  for (const render::Containment& c : report.shapes) {
    by_parity += c.by_parity, by_winding += c.by_winding();
    if (innermost == nullptr && c.by_parity && c.agree()) innermost = &c;
  }
  for (int k = 0; k < 3; ++k) row[static_cast<std::size_t>(kX + k)] = query.point[k];
  if (innermost != nullptr) row[kMaterial] = text(scene_->names(innermost->shape).material);
  row[kSide] = std::string_view(word_of(report.inside()));
  row[kInterior] = text(report.medium);
  row[kParity] = by_parity, row[kWinding] = by_winding;
  take(row);
  std::int64_t number = 0;
  for (const render::Containment& c : report.shapes) {
    row = empty;
    row[kRow] = ++number;
    put_shape(*scene_, c.shape, c.instance, row);
    if (std::isfinite(c.leaves_at)) row[kT] = c.leaves_at;
    row[kSide] = std::string_view(c.agree() ? "inside" : "unsure");
    row[kParity] = integer(c.by_parity);
    row[kWinding] = c.winding;
    row[kClosed] = yes_or_no(c.closed);
    take(row);
  }
}

void GeometryQuery::answer_closest(const Query& query, Row& row, const TakeRow& take) const {
  const render::ClosestReport report = scene_->closest(vector_of(query.point));
  if (report.hit) {
    row[kRow] = integer(1);
    put_hit(*scene_, *report.hit, row);
    row[kSide] = std::string_view(report.hit->from_front ? "front" : "behind");
    row[kError] = report.error;
  }
  take(row);
}

void GeometryQuery::bounds(const TakeRow& take) const {
  for (const render::BoundsReport& report : scene_->bounds()) {
    Row row(std::size(kBoundsColumns));
    if (report.shape >= 0) {
      row[0] = integer(scene_->names(report.shape).number);
      row[1] = text(scene_->names(report.shape).name);
    }
    if (report.instance >= 0 && scene_->instance_number(report.instance) > 0)
      row[2] = integer(scene_->instance_number(report.instance));
    for (int k = 0; k < 3 && report.low.x <= report.high.x; ++k) {
      row[static_cast<std::size_t>(3 + k)] = report.low[k];
      row[static_cast<std::size_t>(6 + k)] = report.high[k];
    }
    row[9] = yes_or_no(report.tight);
    row[10] = yes_or_no(report.unbounded);
    take(row);
  }
}

void GeometryQuery::watertight(const TakeRow& take) const {
  for (const render::ShapeReport& report : scene_->inspect()) {
    Row row(std::size(kWatertightColumns));
    row[0] = integer(scene_->names(report.shape).number);
    row[1] = text(scene_->names(report.shape).name);
    const Row of_shape = row;
    row[2] = yes_or_no(report.mesh.closed);
    if (report.is_mesh) {
      row[3] = report.mesh.triangles, row[4] = report.mesh.vertices, row[5] = report.mesh.edges;
      row[6] = integer(static_cast<std::int64_t>(report.mesh.defects.size()));
    }
    take(row);
    for (const render::DefectPlace& place : report.mesh.defects) {
      row = of_shape;
      row[7] = render::name_of(place.defect);
      row[8] = integer(place.faces), row[9] = integer(place.primitive);
      const render::V3d from = scene_->in_world(report.shape, place.from),
                        to = scene_->in_world(report.shape, place.to);
      for (int k = 0; k < 3; ++k) {
        row[static_cast<std::size_t>(10 + k)] = from[k];
        row[static_cast<std::size_t>(13 + k)] = to[k];
      }
      take(row);
    }
  }
}

}  // namespace tessera::client
