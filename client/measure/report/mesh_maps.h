// Maps of measured surfaces: pictures of them in false colours, their values as pixels, and meshes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "image/image.h"
#include "measure/measured.h"
#include "measure/report/plane_maps.h"

namespace tessera::client {

struct MeshMapOptions {
  PlaneMapOptions maps{};
  bool y_up = false;           // of pictures: else z is
  std::uint32_t pixels = 840;  // along their longer side
};

/// A surface as it is seen from far away, by pixels: values and their standard errors, NaN beside it, and the
/// numbers of the triangles, -1 beside it.
struct MeshView {
  ValueGrid values, errors;
  std::vector<std::int32_t> triangles;
};

/// Looks from that corner of space from which most of the surface shows the side that was measured; the other
/// side is not drawn, so that one looks into rooms. InvalidArgument where the meter lacks readings.
absl::StatusOr<MeshView> view_of(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                                 const MeshMapOptions& options);

/// How the picture looks: titles, unit, and a scale over all triangles, also those that it does not show.
FalseColorOptions false_color_of(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                                 const PlaneMapOptions& options);

/// The bytes of a PLY file (binary, little-endian): triangles in their order, with corners of their own,
/// wound about the side that was measured. Both have `red green blue` (uchar, sRGB), triangles a `value` and
/// its `standard_error` (float, NaN where there is none). InvalidArgument where the meter lacks readings.
absl::StatusOr<std::string> mesh_ply(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                                     const PlaneMapOptions& options);

/// Writes a picture as .png or .svg, its values as .exr (channels Y, error.Y and triangle), or the mesh as
/// .ply. InvalidArgument for another kind of file, or where the meter lacks readings.
absl::Status write_mesh_map(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                            const MeshMapOptions& options, const std::string& path);

}  // namespace tessera::client
