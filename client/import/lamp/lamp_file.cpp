#include "import/lamp/lamp_file.h"

#include <utility>

#include "import/input/input_file.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/units/spelling.h"

namespace tessera::client {

bool is_lamp_file(std::string_view name) {
  const std::string small = photometry::lower(name);
  return small.ends_with(".ies") || small.ends_with(".ldt");
}

absl::StatusOr<v1::BlobRef> add_lamp_file(const std::filesystem::path& path, const std::string& hint,
                                          BlobCollector& blobs, std::vector<std::string>& warnings) {
  const absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  photometry::LampFileOptions options{.name = path.string()};
  bool has_tilt_file = false;
  options.tilt_files = [&](const std::string& name) -> absl::StatusOr<std::string> {
    const absl::StatusOr<InputFile> tilt = InputFile::open(path.parent_path() / name);
    if (!tilt.ok()) return tilt.status();
    has_tilt_file = true;
    return std::string(tilt->bytes());
  };
  auto luminaire = photometry::read_lamp_file(file->bytes(), options, warnings);
  if (!luminaire.ok()) return luminaire.status();
  if (!has_tilt_file) return blobs.add_file(path, hint);
  luminaire->tilt.file.clear();
  auto whole = photometry::write_ies(*luminaire);
  if (!whole.ok()) return whole.status();
  v1::BlobRef blob = blobs.add_bytes(*std::move(whole));
  blob.set_path(hint);
  return blob;
}

absl::StatusOr<v1::BlobRef> add_lamp_bytes(std::string bytes, const std::string& hint, BlobCollector& blobs,
                                           std::vector<std::string>& warnings) {
  const auto luminaire = photometry::read_lamp_file(bytes, {.name = hint}, warnings);
  if (!luminaire.ok()) return luminaire.status();
  v1::BlobRef blob = blobs.add_bytes(std::move(bytes));
  blob.set_path(hint);
  return blob;
}

}  // namespace tessera::client
