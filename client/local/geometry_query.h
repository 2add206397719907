// Questions about a scene's geometry, answered in this process: `tessera query`.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "tessera/v1/job.pb.h"

namespace tessera::render {
class QueryScene;
struct SurfaceHit;
}  // namespace tessera::render

namespace tessera::client {

enum class QueryKind : std::uint8_t { kRay, kInside, kClosest };

/// A question about places in world space. A direction may have any length.
struct Query {
  QueryKind kind = QueryKind::kRay;
  double point[3] = {0, 0, 0};
  double direction[3] = {0, 0, 0};  // kRay
};

/// One value of a table; nothing where a column does not apply. Floats are what is known in single precision.
/// Texts live as long as the GeometryQuery.
using Cell = std::variant<std::monostate, std::int64_t, double, float, std::string_view>;
using Row = std::vector<Cell>;
using Columns = std::span<const char* const>;
using TakeRow = std::function<void(const Row&)>;

struct GeometryOptions {
  double shutter_time = 0;  // 0: the shutter opens, 1: it closes
  // The point of world space about which coordinates are rounded to floats; none: as when it is rendered.
  std::optional<std::array<double, 3>> origin;
  int threads = 1;  // threads for building
};

class GeometryQuery {
 public:
  /// Builds the scene of `spec`, whose ISA must be set. InvalidArgument names what is wrong with the scene.
  static absl::StatusOr<std::unique_ptr<GeometryQuery>> load(const v1::JobSpec& spec,
                                                             const std::vector<const SceneBlob*>& blobs,
                                                             const GeometryOptions& options);
  ~GeometryQuery();

  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Shapes whose answers to such queries are not exact, in one line; empty where there are none.
  std::string doubts(bool closest) const;

  /// docs/query.md says what the columns hold.
  static Columns answer_columns();
  static Columns bounds_columns();
  static Columns watertight_columns();

  /// Answers queries in their order, each by one row at least with its number in the first column; that of
  /// the first is `number`. Those that could not be read have a number, too, but no row. Safe to call from
  /// any number of threads at once.
  void answer(std::span<const std::optional<Query>> queries, std::int64_t number, const TakeRow& take) const;
  void bounds(const TakeRow& take) const;
  void watertight(const TakeRow& take) const;

 private:
  explicit GeometryQuery(std::unique_ptr<const render::QueryScene> scene);
  void answer_ray(const std::vector<render::SurfaceHit>& hits, Row& row, const TakeRow& take) const;
  void answer_inside(const Query& query, Row& row, const TakeRow& take) const;
  void answer_closest(const Query& query, Row& row, const TakeRow& take) const;

  std::unique_ptr<const render::QueryScene> scene_;
  std::vector<std::string> warnings_;
};

}  // namespace tessera::client
