#include "measure/meter_file.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "google/protobuf/io/tokenizer.h"
#include "google/protobuf/text_format.h"
#include "import/input/input_file.h"

namespace tessera::client {

namespace {

using google::protobuf::TextFormat;

class SyntaxFaults : public google::protobuf::io::ErrorCollector {
 public:
  SyntaxFaults(Diagnostics& diagnostics, std::uint32_t file) : diagnostics_(diagnostics), file_(file) {}

  void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    diagnostics_.error({file_, static_cast<std::uint32_t>(line + 1), static_cast<std::uint32_t>(column + 1)},
                       message);
  }

 private:
  Diagnostics& diagnostics_;
  const std::uint32_t file_;
};

std::string title_of(const v1::MeterList& list, std::size_t meter) {
  const std::string& name = list.meters(static_cast<int>(meter)).name();
  return absl::StrCat("meter ", meter + 1, name.empty() ? "" : absl::StrCat(" (", name, ")"), ": ");
}

}  // namespace

absl::Status MeterFile::status_of(const std::vector<std::pair<std::size_t, std::string>>& faults) const {
  Diagnostics diagnostics;
  const std::uint32_t file = diagnostics.add_file(path);
  for (const auto& [meter, message] : faults)
    diagnostics.error({file, line_of_meter[meter]}, absl::StrCat(title_of(list, meter), message));
  return diagnostics.status();
}

absl::Status MeterFile::fault_of_series(const std::string& message) const {
  Diagnostics diagnostics;
  diagnostics.error({diagnostics.add_file(path), line_of_series}, absl::StrCat("series: ", message));
  return diagnostics.status();
}

absl::StatusOr<MeterFile> read_meter_file(const std::string& path) {
  const absl::StatusOr<InputFile> input = InputFile::open(path);
  if (!input.ok()) return input.status();
  MeterFile file;
  file.path = path;
  Diagnostics diagnostics;
  SyntaxFaults faults(diagnostics, diagnostics.add_file(path));
  TextFormat::ParseInfoTree places;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&faults);
  parser.WriteLocationsTo(&places);
  if (!parser.ParseFromString(std::string(input->bytes()), &file.list)) return diagnostics.status();
  const auto* const meters = v1::MeterList::descriptor()->FindFieldByName("meters");
  for (int i = 0; i < file.list.meters_size(); ++i)
    file.line_of_meter.push_back(static_cast<std::uint32_t>(places.GetLocation(meters, i).line + 1));
  if (file.list.has_series()) {
    const auto* const series = v1::MeterList::descriptor()->FindFieldByName("series");
    file.line_of_series = static_cast<std::uint32_t>(places.GetLocation(series, -1).line + 1);
  }
  if (file.list.meters_size() == 0)
    return absl::InvalidArgumentError(absl::StrCat(path, ": it has no meters"));
  return file;
}

}  // namespace tessera::client
