#include "measure/weather_file.h"

#include <cstdint>
#include <vector>

#include "import/input/diagnostics.h"
#include "import/input/input_file.h"
#include "photometry/weather/epw.h"

namespace tessera::client {

absl::StatusOr<photometry::Weather> read_weather(const std::string& path) {
  const absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  std::vector<photometry::WeatherFault> faults;
  photometry::Weather weather = photometry::read_epw(file->bytes(), faults);
  Diagnostics diagnostics;
  const std::uint32_t number = diagnostics.add_file(path);
  for (const photometry::WeatherFault& fault : faults) {
    diagnostics.error(
        {number, static_cast<std::uint32_t>(fault.line), static_cast<std::uint32_t>(fault.column)},
        fault.message);
  }
  if (diagnostics.has_errors()) return diagnostics.status();
  return weather;
}

}  // namespace tessera::client
