#include "service/web/pixel_units.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "store/blobs/blob_store.h"
#include "wire/exposure.h"
#include "wire/film_sensor.h"

namespace tessera::server {
namespace {

using google::protobuf::internal::WireFormatLite;

/// A blob as protobuf reads it: pieces that are skipped are not read.
class BlobInput final : public google::protobuf::io::ZeroCopyInputStream {
 public:
  explicit BlobInput(const BlobReader& blob) : blob_(blob) {}

  bool Next(const void** data, int* size) override {
    absl::StatusOr<std::string> piece = blob_.read(at_, kPiece);
    if (!piece.ok() || piece->empty()) return false;
    piece_ = *std::move(piece);
    at_ += piece_.size();
    *data = piece_.data();
    *size = static_cast<int>(piece_.size());
    return true;
  }
  void BackUp(int count) override { at_ -= static_cast<std::uint64_t>(count); }
  bool Skip(int count) override {
    const std::uint64_t left = blob_.size() - std::min(at_, blob_.size());
    at_ += std::min(static_cast<std::uint64_t>(count), left);
    return static_cast<std::uint64_t>(count) <= left;
  }
  std::int64_t ByteCount() const override { return static_cast<std::int64_t>(at_); }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 16;

  const BlobReader& blob_;
  std::uint64_t at_ = 0;
  std::string piece_;
};

bool is_wanted(int field) {
  return field == v1::Scene::kCameraFieldNumber || field == v1::Scene::kFilmFieldNumber ||
         field == v1::Scene::kUnitsFieldNumber;
}

/// Sets what tells luminance; false where nothing does.
bool set_weights(const v1::JobSpec& spec, PixelUnits& units) {
  spectra::RgbSpace space = spectra::kRec709;
  if (spec.content().algorithms().color() == v1::COLOR_SPECTRAL) {
    const auto film = wire::film_sensor_of(spec.view());
    if (!film.ok() || film->sensor.kind != spectra::SensorKind::kObserver) {
      units.about = "Red, green and blue are those of a sensor, which tell no luminance.";
      return false;
    }
    space = film->space;
  }
  units.weights = spectra::xyz_from_rgb(space)[1];
  return true;
}

}  // namespace

absl::StatusOr<v1::Scene> read_scene_head(const BlobReader& scene) {
  constexpr std::uint32_t kMostBytes = std::uint32_t{1} << 24;  // of one of the wanted fields
  BlobInput input(scene);
  google::protobuf::io::CodedInputStream coded(&input);
  coded.SetTotalBytesLimit(std::numeric_limits<int>::max());
  std::string head;
  const absl::Status unsound = absl::InvalidArgumentError("the job's scene cannot be read");
  while (const std::uint32_t tag = coded.ReadTag()) {
    const bool is_message = WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
    if (!is_message || !is_wanted(WireFormatLite::GetTagFieldNumber(tag))) {
      if (!WireFormatLite::SkipField(&coded, tag)) return unsound;
      continue;
    }
    std::uint32_t size = 0;
    std::string field;
    if (!coded.ReadVarint32(&size) || size > kMostBytes || !coded.ReadString(&field, static_cast<int>(size)))
      return unsound;
    google::protobuf::io::StringOutputStream output(&head);
    google::protobuf::io::CodedOutputStream copy(&output);
    copy.WriteTag(tag);
    copy.WriteVarint32(size);
    copy.WriteString(field);
  }
  v1::Scene found;
  if (!coded.ConsumedEntireMessage() || !found.ParseFromString(head)) return unsound;
  return found;
}

PixelUnits pixel_units_of(const v1::Scene& head, const v1::JobSpec& spec) {
  PixelUnits units;
  if (!set_weights(spec, units)) return units;
  const auto exposure = wire::film_exposure(head.film(), spec.view().exposure());
  const auto scale = exposure.ok() ? wire::exposure_scale(*exposure, head.camera())
                                   : absl::StatusOr<double>(exposure.status());
  if (!scale.ok() || !(*scale > 0)) {
    units.about = "The film's exposure does not tell what luminance its pixels have.";
    return units;
  }
  if (wire::is_irradiance(head.camera())) {
    units.about = "Pixels are the irradiance of the film, which has no luminance.";
    return units;
  }
  const bool said = head.units().cd_per_m2() > 0;
  // Photographic exposures are those of scenes whose lights are in cd/m^2, unless they say otherwise.
  double cd_per_m2 = kUsualCdPerM2;
  if (said) {
    cd_per_m2 = head.units().cd_per_m2();
  } else if (exposure->photographic) {
    const double stated = exposure->photographic->cd_per_m2();
    cd_per_m2 = stated > 0 ? stated : 1;
  } else {
    units.about =
        "The scene does not say its units: radiance is taken to be in W/(m\u00b2 sr), with 683 lm/W.";
  }
  units.cd_per_m2 = cd_per_m2 / *scale;
  if (cd_per_m2 == kUsualCdPerM2) units.radiance = 1 / *scale;
  return units;
}

PixelUnits usual_pixel_units(const v1::JobSpec& spec) {
  PixelUnits units;
  if (!set_weights(spec, units)) return units;
  units.cd_per_m2 = kUsualCdPerM2, units.radiance = 1;
  units.about =
      "The job's scene cannot be read any more: radiance is taken to be in W/(m\u00b2 sr), with 683 lm/W and "
      "no "
      "exposure.";
  return units;
}

}  // namespace tessera::server
