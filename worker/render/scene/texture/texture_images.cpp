#include "render/scene/texture/texture_images.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/color/mip_pyramid.h"
#include "render/color/texture_load.h"
#include "render/scene/values/located.h"
#include "render/scene/values/parallel.h"

namespace tessera::render {

namespace {

TexelEncoding encoding_of(const v1::ImageTexture& image) {
  switch (image.encoding()) {
    case v1::ImageTexture::LINEAR:
      return TexelEncoding::kLinear;
    case v1::ImageTexture::SRGB:
      return TexelEncoding::kSrgb;
    case v1::ImageTexture::GAMMA:
      return TexelEncoding::kGamma;
    default:
      return TexelEncoding::kAuto;
  }
}

}  // namespace

std::shared_ptr<const TextureImage> TextureImages::slot(const v1::ImageTexture& image, bool pyramid) {
  const std::string key = absl::StrCat(image.image().digest(), "/", static_cast<int>(encoding_of(image)), "/",
                                       image.gamma(), pyramid ? "/pyramid" : "");
  Slot& slot = slots_[key];
  if (!slot.image) {
    std::shared_ptr<TextureImage> known = shared_ == nullptr ? nullptr : shared_->find(key);
    const bool decoded = known != nullptr;
    slot = {&image, pyramid, decoded, decoded ? std::move(known) : std::make_shared<TextureImage>()};
  }
  return slot.image;
}

std::shared_ptr<const TextureImage> TextureImages::twin(const TextureImage* slot, bool pyramid) {
  for (const auto& [key, known] : slots_) {
    if (known.image.get() == slot) return this->slot(*known.source, pyramid);
  }
  return nullptr;
}

std::vector<std::pair<const v1::ImageTexture*, absl::Status>> TextureImages::refusals(
    const BlobSource& blobs) const {
  const auto check = [&](const Slot& slot) {
    const v1::BlobRef& file = slot.source->image();
    const auto bytes = blobs(file.digest());
    if (!bytes.ok()) return located(bytes.status(), absl::StrCat("image '", file.path(), "'"));
    const auto size = check_texture_image(bytes->bytes, file.path());
    if (!size.ok() || !slot.pyramid) return size.status();
    return check_pyramid(size->width, size->height, file.path());
  };
  std::vector<std::pair<const v1::ImageTexture*, absl::Status>> refused;
  for (const auto& [key, slot] : slots_) {
    if (!needed_.contains(slot.image.get())) continue;
    if (absl::Status status = check(slot); !status.ok()) refused.emplace_back(slot.source, std::move(status));
  }
  return refused;
}

absl::Status TextureImages::decode(const BlobSource& blobs, int threads) {
  std::vector<const std::pair<const std::string, Slot>*> wanted;
  for (const auto& entry : slots_) {
    if (!entry.second.decoded && needed_.contains(entry.second.image.get())) wanted.push_back(&entry);
  }
  return parallel_for(wanted.size(), threads, [&](std::size_t i) -> absl::Status {
    const auto& [key, slot] = *wanted[i];
    const v1::ImageTexture& image = *slot.source;
    auto bytes = blobs(image.image().digest());
    if (!bytes.ok()) return located(bytes.status(), absl::StrCat("image '", image.image().path(), "'"));
    auto loaded = load_texture_image(bytes->bytes, image.image().path(), {encoding_of(image), image.gamma()});
    if (!loaded.ok()) return loaded.status();
    if (slot.pyramid) {
      if (auto s = make_pyramid(*loaded, image.image().path()); !s.ok()) return s;
    }
    *slot.image = *std::move(loaded);
    if (shared_ != nullptr) shared_->add(key, slot.image);
    return absl::OkStatus();
  });
}

}  // namespace tessera::render
