#include "render/textbook/preview/frame.h"

#include <algorithm>
#include <cmath>

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr std::size_t kClustersAPiece = 1024;

/// Views that clip nothing see from this part of the scene's size on.
constexpr float kNearest = 1e-5f;

/// Pixels by which a filter's samples lie off their pixels.
int reach_of(const PixelFilterRecord& filter) {
  return static_cast<int>(std::ceil(std::max(filter.x.radius, filter.y.radius)));
}

}  // namespace

PreviewFrame::PreviewFrame(const SceneTables& scene)
    : scene_(scene), clusters_(scene.shapes), lighting_(lighting_of(scene)) {
  add_eye(scene.sensor, reach_of(scene.filter), -1, nullptr, 0);
  if (scene.preview.shadows != ShadowKind::kNone) add_shadow_maps();
  work_ = std::make_unique<SharedWork>(stages());
}

void PreviewFrame::add_shadow_maps() {
  const std::size_t count = std::min(lighting_.lamps.size(), kMostShadowMaps);
  for (const Lamp& lamp : std::span(lighting_.lamps).first(count)) {
    ShadowMap& map = *shadows_.emplace_back(std::make_unique<ShadowMap>(scene_, lamp));
    for (std::size_t face = 0; face < map.faces(); ++face) {
      add_eye(map.sensor(face), 1, lamp.shape, &map, face);
      for (int row = 0; row < eyes_.back().bins->rows(); ++row)
        shadow_bin_rows_.emplace_back(eyes_.size() - 1, row);
    }
  }
}

void PreviewFrame::add_eye(const SensorRecord& sensor, int reach, std::int32_t without, ShadowMap* map,
                           std::size_t face) {
  Eye eye{&sensor, nullptr, {}, map, face};
  const float least = std::max(kNearest * scene_.lights.scene_radius, 1e-30f);
  eye.bins = std::make_unique<Bins>(clusters_, scene_.shapes, projection_of(sensor, least, reach));
  for (std::size_t i = 0; i < scene_.shapes.shapes.size(); ++i) {
    const MaterialRecord& material =
        scene_.materials.materials[static_cast<std::size_t>(scene_.shapes.shapes[i].material)];
    // Sheets that light passes straight do not shadow it.
    const bool there = material.kind != kNoSurface && (map == nullptr || !(material.flags & kPassesStraight));
    eye.shape_seen.push_back(there && static_cast<std::int32_t>(i) != without);
  }
  eyes_.push_back(std::move(eye));
}

std::vector<SharedWork::Stage> PreviewFrame::stages() {
  const std::size_t cluster_pieces = (clusters_.size() + kClustersAPiece - 1) / kClustersAPiece;
  const std::size_t pieces = eyes_.front().bins->pieces();
  return {{cluster_pieces,
           [this](std::size_t i, const RayQuery&) {
             clusters_.fill(i * kClustersAPiece, std::min((i + 1) * kClustersAPiece, clusters_.size()));
           }},
          {eyes_.size() * pieces,
           [this, pieces](std::size_t i, const RayQuery&) {
             const Eye& eye = eyes_[i / pieces];
             eye.bins->find(i % pieces, eye.shape_seen);
           }},
          {eyes_.size(), [this](std::size_t i, const RayQuery&) { eyes_[i].bins->sort(); }},
          {shadow_bin_rows_.size(), [this](std::size_t i, const RayQuery& rays) { draw_row(i, rays); }}};
}

void PreviewFrame::draw_row(std::size_t piece, const RayQuery& rays) const {
  const auto [index, row] = shadow_bin_rows_[piece];
  const Eye& eye = eyes_[index];
  const View view{*eye.sensor, *eye.bins, eye.shape_seen};
  const auto raster = std::make_unique<Raster>(scene_, clusters_, rays);
  for (int column = 0; column < eye.bins->columns(); ++column) {
    raster->render(view, column, row);
    eye.map->put(eye.face, column, row, raster->nearness());
  }
}

}  // namespace tessera::render::TESSERA_ISA
