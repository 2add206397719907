#include "capture/pictures.h"

#include <algorithm>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "light_field/refocus.h"

namespace tessera::client {
namespace {

using light_field::LightField;
using light_field::Picture;
using light_field::Rgba;

constexpr std::pair<const char*, std::size_t> kPlanes[] = {{"R", 0}, {"G", 1}, {"B", 2}, {"A", 3}};

Image empty_image(std::uint32_t width, std::uint32_t height) {
  Image image;
  image.data = image.display = {0, 0, static_cast<std::int32_t>(width), static_cast<std::int32_t>(height)};
  return image;
}

template <class PixelOf>
void add_planes(const PixelOf& pixel, Image& image) {
  for (const auto& [name, place] : kPlanes) {
    std::vector<float>& values = image.add(name).values;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = pixel(i)[place];
  }
}

}  // namespace

Image image_of(const Picture& picture) {
  Image image = empty_image(picture.width, picture.height);
  add_planes([&](std::size_t i) { return picture.pixels[i]; }, image);
  image.add("known").values = picture.known;
  return image;
}

absl::StatusOr<Image> image_of_view(LightField& field, std::uint32_t view) {
  const light_field::Manifest& manifest = field.manifest();
  light_field::ViewPixels& pixels = field.pixels(view);
  pixels.load();
  if (const auto damage = pixels.damage(); !damage.empty())
    return absl::InvalidArgumentError(absl::StrCat(field.folder(), ": ", damage.front().text()));
  Image image = empty_image(manifest.width, manifest.height);
  add_planes([&](std::size_t i) { return pixels.pixel(i); }, image);
  std::vector<float>& depth = image.add("depth.Z").values;
  const light_field::Pinhole& camera = manifest.views[view].camera;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const float inverse = pixels.inverse_z(i);
    const auto x = static_cast<double>(i % manifest.width), y = static_cast<double>(i / manifest.width);
    depth[i] = inverse > 0 ? static_cast<float>(camera.direction(x + 0.5, y + 0.5).length()) / inverse : 0;
  }
  pixels.release();
  image.metadata["view"] =
      manifest.views[view].name.empty() ? absl::StrCat("v", view) : manifest.views[view].name;
  return image;
}

absl::StatusOr<Picture> quilt_of(LightField& field, const QuiltSize& quilt, light_field::Interpolation by,
                                 int threads) {
  const light_field::Manifest& manifest = field.manifest();
  const auto grid = light_field::only_grid(manifest);
  if (!grid.ok()) return grid.status();
  const std::uint32_t views = quilt.columns * quilt.rows;
  Picture all;
  all.width = quilt.columns * manifest.width, all.height = quilt.rows * manifest.height;
  all.pixels.resize(std::size_t{all.width} * all.height);
  all.known.resize(all.pixels.size());
  const double span = (grid->columns - 1) * grid->spacing_x;
  for (std::uint32_t view = 0; view < views; ++view) {
    const double part = views > 1 ? static_cast<double>(view) / (views - 1) : 0.5;
    const light_field::Pinhole eye = camera_of_grid(manifest, *grid, (part - 0.5) * span, 0);
    light_field::PictureRequest request;
    request.width = manifest.width, request.height = manifest.height, request.by = by;
    request.threads = threads;
    request.rays = [&](std::uint32_t y, std::span<light_field::Ray> row) {
      for (std::size_t x = 0; x < row.size(); ++x)
        row[x] = {eye.place(), eye.direction(static_cast<double>(x) + 0.5, y + 0.5)};
    };
    const auto picture = interpolate(field, request);
    if (!picture.ok()) return picture.status();
    const std::size_t left = std::size_t{view % quilt.columns} * manifest.width;
    const std::size_t top = std::size_t{quilt.rows - 1 - view / quilt.columns} * manifest.height;
    for (std::size_t y = 0; y < manifest.height; ++y) {
      const auto from = static_cast<std::ptrdiff_t>(y * manifest.width);
      const auto to = static_cast<std::ptrdiff_t>((top + y) * all.width + left);
      std::copy_n(picture->pixels.begin() + from, manifest.width, all.pixels.begin() + to);
      std::copy_n(picture->known.begin() + from, manifest.width, all.known.begin() + to);
    }
    all.rays += picture->rays, all.missing += picture->missing;
  }
  return all;
}

}  // namespace tessera::client
