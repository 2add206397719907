#include "import/lens/lens_file.h"

#include "absl/strings/ascii.h"
#include "google/protobuf/io/tokenizer.h"
#include "google/protobuf/text_format.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "optics/read/pbrt_lens_file.h"
#include "optics/read/zemax_file.h"
#include "tessera/v1/camera.pb.h"
#include "wire/lens_message.h"

namespace tessera::client {
namespace {

using google::protobuf::TextFormat;

class FaultCollector : public google::protobuf::io::ErrorCollector {
 public:
  explicit FaultCollector(std::vector<optics::Fault>& faults) : faults_(faults) {}

  void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    faults_.push_back({line + 1, column + 1, message});
  }

 private:
  std::vector<optics::Fault>& faults_;
};

optics::Prescription read_text(std::string_view text, std::vector<optics::Fault>& faults) {
  v1::LensPrescription message;
  FaultCollector collector(faults);
  TextFormat::ParseInfoTree places;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&places);
  if (!parser.ParseFromString(std::string(text), &message)) return {};
  const auto* const surfaces = v1::LensPrescription::descriptor()->FindFieldByName("surfaces");
  const auto line_of = [&](std::size_t surface) {
    return places.GetLocation(surfaces, static_cast<int>(surface)).line + 1;
  };
  const std::size_t before = faults.size();
  optics::Prescription lens = wire::prescription_of(message, faults);
  for (std::size_t i = 0; i < lens.surfaces.size(); ++i) lens.surfaces[i].line = line_of(i);
  for (std::size_t i = before; i < faults.size(); ++i) {
    const std::size_t surface = faults[i].surface;
    if (surface > 0) faults[i].line = line_of(surface - 1);
  }
  return lens;
}

}  // namespace

absl::Status status_of(const std::vector<optics::Fault>& faults, const std::string& file) {
  Diagnostics diagnostics;
  const std::uint32_t number = diagnostics.add_file(file);
  for (const optics::Fault& fault : faults) {
    diagnostics.error(
        {number, static_cast<std::uint32_t>(fault.line), static_cast<std::uint32_t>(fault.column)},
        fault.message);
  }
  return diagnostics.status();
}

absl::StatusOr<LensFile> read_lens_file(const std::filesystem::path& path) {
  const absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  LensFile result;
  std::vector<optics::Fault> faults;
  const std::string extension = absl::AsciiStrToLower(path.extension().string());
  if (extension == ".zmx") {
    optics::ZemaxLens zemax = optics::read_zemax_lens(file->bytes(), faults);
    result.lens = std::move(zemax.lens);
    result.f_number = zemax.f_number;
    for (const std::string& operand : zemax.ignored)
      result.warnings.push_back(concat(path.string(), ": ", operand, " is not read"));
  } else if (extension == ".textproto" || extension == ".pbtxt") {
    result.lens = read_text(file->bytes(), faults);
  } else if (extension == ".dat" || extension == ".txt") {
    result.lens = optics::read_pbrt_lens(file->bytes(), faults);
  } else {
    return absl::InvalidArgumentError(
        concat(path.string(), ": lenses are read from .textproto, .dat (pbrt) and .zmx (Zemax)"));
  }
  if (!faults.empty()) return status_of(faults, path.string());
  return result;
}

}  // namespace tessera::client
