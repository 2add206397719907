#include "light_field/light_field.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "wire/digest.h"

namespace tessera::light_field {

std::string Damage::text() const {
  if (whole_file)
    return absl::StrCat("view ", view, ": its file is not there, or not the one that was written");
  const std::string where = absl::StrCat("view ", view, ", tile ", column, ",", row, ": ");
  if (found == expected) return where + "it cannot be decoded";
  return absl::StrCat(where, "its hash is ", found == 0 ? "that of no bytes" : hash_text(found), ", not ",
                      hash_text(expected));
}

ViewPixels::ViewPixels(const Manifest& manifest, const std::string& folder, std::uint32_t number)
    : manifest_(manifest),
      folder_(folder),
      number_(number),
      width_(static_cast<float>(manifest.width)),
      height_(static_cast<float>(manifest.height)),
      columns_(manifest.tile_columns()),
      rows_(manifest.tile_rows()),
      shift_(static_cast<std::uint32_t>(std::countr_zero(manifest.tile_size))),
      states_(std::make_unique<std::atomic<std::uint8_t>[]>(std::size_t{columns_} * rows_)) {}

bool ViewPixels::find(float x, float y, Footprint& footprint) {
  const float left = std::max(x - 0.5f, 0.0f), above = std::max(y - 0.5f, 0.0f);
  const auto x0 = std::min(static_cast<std::uint32_t>(left), manifest_.width - 1);
  const auto y0 = std::min(static_cast<std::uint32_t>(above), manifest_.height - 1);
  const std::uint32_t x1 = std::min(x0 + 1, manifest_.width - 1), y1 = std::min(y0 + 1, manifest_.height - 1);
  const std::uint32_t c0 = x0 >> shift_, r0 = y0 >> shift_, c1 = x1 >> shift_, r1 = y1 >> shift_;
  if (!ensure(c0, r0)) return false;
  if ((c0 != c1 || r0 != r1) && !(ensure(c1, r0) && ensure(c0, r1) && ensure(c1, r1))) return false;
  const std::size_t row0 = std::size_t{y0} * manifest_.width, row1 = std::size_t{y1} * manifest_.width;
  footprint = {row0 + x0,
               row0 + x1,
               row1 + x0,
               row1 + x1,
               std::min(left - static_cast<float>(x0), 1.0f),
               std::min(above - static_cast<float>(y0), 1.0f)};
  return true;
}

bool ViewPixels::look(float x, float y, Seen& seen) {
  Footprint at;
  if (!find(x, y, at)) return false;
  const Rgba above = rgba_[at.i00] + (rgba_[at.i10] - rgba_[at.i00]) * at.u;
  const Rgba below = rgba_[at.i01] + (rgba_[at.i11] - rgba_[at.i01]) * at.u;
  seen.rgba = above + (below - above) * at.v;
  seen.inverse_z = mean_inverse_z(at);
  return true;
}

float ViewPixels::inverse_z(float x, float y) {
  Footprint at;
  return find(x, y, at) ? mean_inverse_z(at) : 0;
}

float ViewPixels::mean_inverse_z(const Footprint& at) const {
  // std::lerp costs several times as much.
  const float above = inverse_z_[at.i00] + (inverse_z_[at.i10] - inverse_z_[at.i00]) * at.u;
  const float below = inverse_z_[at.i01] + (inverse_z_[at.i11] - inverse_z_[at.i01]) * at.u;
  return above + (below - above) * at.v;
}

void ViewPixels::load() {
  for (std::uint32_t row = 0; row < rows_; ++row)
    for (std::uint32_t column = 0; column < columns_; ++column) static_cast<void>(ensure(column, row));
}

void ViewPixels::release() {
  const std::lock_guard lock(mutex_);
  for (std::uint32_t i = 0; i < columns_ * rows_; ++i) {
    if (states_[i] == kThere) states_[i] = kAbsent;
  }
  rgba_.reset(), inverse_z_.reset(), file_.reset();
}

std::vector<Damage> ViewPixels::damage() const {
  const std::lock_guard lock(mutex_);
  return damage_;
}

bool ViewPixels::read(std::uint32_t column, std::uint32_t row) {
  const std::lock_guard lock(mutex_);
  std::atomic<std::uint8_t>& state = states_[row * columns_ + column];
  if (state == kAbsent) state.store(read_locked(column, row), std::memory_order_release);
  return state == kThere;
}

ViewPixels::State ViewPixels::read_locked(std::uint32_t column, std::uint32_t row) {
  const View& view = manifest_.views[number_];
  const Tile& tile = view.tiles[row * columns_ + column];
  Damage damage{number_, column, row, false, tile.hash, 0};
  if (file_ == nullptr) {
    auto opened = TileFileReader::open(data_file(folder_, view));
    const bool fits =
        opened.ok() && (*opened)->width() == manifest_.width && (*opened)->height() == manifest_.height;
    if (!fits) {
      damage.whole_file = true;
      if (damage_.empty()) damage_.push_back(damage);
      return kDamaged;
    }
    file_ = *std::move(opened);
  }
  if (rgba_ == nullptr) {
    const std::size_t pixels = std::size_t{manifest_.width} * manifest_.height;
    rgba_ = std::make_unique_for_overwrite<Rgba[]>(pixels);
    inverse_z_ = std::make_unique_for_overwrite<float[]>(pixels);
  }
  const std::string_view bytes = file_->bytes();
  const bool is_there = tile.offset <= bytes.size() && tile.bytes <= bytes.size() - tile.offset;
  if (is_there) damage.found = tile_hash(bytes.substr(tile.offset, tile.bytes));
  const std::size_t first = (std::size_t{row} * manifest_.width + column)
                            << shift_;  // (row << shift) * width + (column << shift)
  const TileTarget target{reinterpret_cast<float*>(rgba_.get() + first), inverse_z_.get() + first,
                          manifest_.width};
  if (damage.found != tile.hash || !file_->read(column, row, target).ok()) {
    damage_.push_back(damage);
    return kDamaged;
  }
  invert_distances(column, row);
  return kThere;
}

void ViewPixels::invert_distances(std::uint32_t column, std::uint32_t row) {
  const Pinhole& camera = manifest_.views[number_].camera;
  const std::uint32_t x0 = column << shift_, y0 = row << shift_;
  const std::uint32_t x1 = std::min(x0 + manifest_.tile_size, manifest_.width);
  const std::uint32_t y1 = std::min(y0 + manifest_.tile_size, manifest_.height);
  // The length of direction(x, y) is that of a + x b, along a row.
  const Imath::V3d along = camera.direction(1, 0) - camera.direction(0, 0);
  for (std::uint32_t y = y0; y < y1; ++y) {
    const Imath::V3d from = camera.direction(0, y + 0.5);
    for (std::uint32_t x = x0; x < x1; ++x) {
      float& distance = inverse_z_[std::size_t{y} * manifest_.width + x];
      const bool is_met = distance > 0 && std::isfinite(distance);
      distance = is_met ? static_cast<float>((from + (x + 0.5) * along).length()) / distance : 0;
    }
  }
}

LightField::LightField(std::string folder, Manifest manifest)
    : folder_(std::move(folder)), manifest_(std::move(manifest)), origin_(manifest_.arrangement.target) {
  for (std::uint32_t v = 0; v < manifest_.views.size(); ++v) {
    projections_.push_back(Projection::of(manifest_.views[v].camera, origin_));
    pixels_.push_back(std::make_unique<ViewPixels>(manifest_, folder_, v));
  }
}

absl::StatusOr<std::unique_ptr<LightField>> LightField::open(const std::string& folder) {
  absl::StatusOr<Manifest> manifest = read_manifest(folder);
  if (!manifest.ok()) return manifest.status();
  return std::unique_ptr<LightField>(new LightField(folder, *std::move(manifest)));
}

std::vector<Damage> LightField::damage() const {
  std::vector<Damage> all;
  for (const auto& view : pixels_) {
    const std::vector<Damage> found = view->damage();
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

std::vector<Damage> check_view(const Manifest& manifest, const std::string& folder, std::uint32_t number) {
  const View& view = manifest.views[number];
  const Damage no_file{number, 0, 0, true, 0, 0};
  const auto file = TileFileReader::open(data_file(folder, view));
  if (!file.ok()) return {no_file};
  const std::string_view bytes = (*file)->bytes();
  if (wire::sha256_hex(bytes) == view.file) return {};
  std::vector<Damage> found;
  for (std::uint32_t i = 0; i < view.tiles.size(); ++i) {
    const Tile& tile = view.tiles[i];
    const bool is_there = tile.offset <= bytes.size() && tile.bytes <= bytes.size() - tile.offset;
    const std::uint64_t hash = is_there ? tile_hash(bytes.substr(tile.offset, tile.bytes)) : 0;
    if (hash != tile.hash)
      found.push_back(
          {number, i % manifest.tile_columns(), i / manifest.tile_columns(), false, tile.hash, hash});
  }
  if (found.empty()) found.push_back(no_file);
  return found;
}

}  // namespace tessera::light_field
