// Scenes given as text, for queries.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/renderer.h"
#include "render/scene/load_query.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/mesh_blob.h"
#include "wire/resolve_settings.h"

namespace tessera::test::query {

using Imath::V3d;
using render::QueryScene;

using Blobs = std::map<std::string, std::string>;

/// The world's origin is that of render space, so that floats of the text stay as they are.
inline absl::StatusOr<std::unique_ptr<const QueryScene>> load(const std::string& text,
                                                              const Blobs& blobs = {}, float time = 0,
                                                              std::vector<std::string>* warnings = nullptr) {
  v1::Scene scene;
  EXPECT_TRUE(
      google::protobuf::TextFormat::ParseFromString(absl::StrCat("render_origin { } ", text), &scene));
  scene.mutable_camera()->mutable_perspective()->set_fov_degrees(40);
  v1::RenderSettings asked;
  asked.set_integrator("volpath");
  v1::JobSpec spec;
  wire::resolve_settings(asked, spec);
  spec.mutable_view()->set_width(16);
  spec.mutable_view()->set_height(16);
  const auto source = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto found = blobs.find(digest);
    if (found == blobs.end()) return absl::NotFoundError(absl::StrCat("blob ", digest));
    return render::BlobBytes{found->second, nullptr};
  };
  std::vector<std::string> unused;
  return render::load_query(scene, spec, source,
                            {.isa = render::supported_isas().front(), .time = time, .threads = 1},
                            warnings != nullptr ? *warnings : unused);
}

inline std::string mesh_blob(const std::vector<float>& positions, const std::vector<std::uint32_t>& indices) {
  return wire::encode_mesh({.positions = positions, .normals = {}, .uvs = {}, .indices = indices});
}

/// The text of a shape whose mesh is the blob of that name.
inline std::string mesh_shape(const std::string& name, const std::string& blob,
                              const std::string& more = "") {
  return absl::StrCat("shapes { name: '", name, "' mesh { blob { digest: '", blob, "' } } ", more, " } ");
}

/// The cube from -1 to 1: twelve triangles, outside out. The last two are the face z = 1.
inline std::vector<float> cube_corners() {
  std::vector<float> corners;
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 3; ++k) corners.push_back(i >> k & 1 ? 1.0f : -1.0f);
  }
  return corners;
}
inline std::vector<std::uint32_t> cube_triangles() {
  return {0, 2, 1, 1, 2, 3, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7,
          0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5, 4, 5, 6, 5, 7, 6};
}

/// Longitudes and latitudes of a sphere, closed: vertices at seams are there twice.
inline std::string sphere_mesh(int rows, int columns) {
  std::vector<float> p;
  std::vector<std::uint32_t> t;
  const double pi = std::acos(-1.0);
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const double theta = pi * i / rows, phi = 2 * pi * (j % columns) / columns;
      const double s = i == 0 || i == rows ? 0 : std::sin(theta);
      p.insert(p.end(), {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
                         static_cast<float>(std::cos(theta))});
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (columns + 1) + j); };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      if (i > 0) t.insert(t.end(), {at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rows) t.insert(t.end(), {at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  return mesh_blob(p, t);
}

}  // namespace tessera::test::query
