#include "command/measure/figure_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "measure/lamp_file_of.h"
#include "measure/report/figure_text.h"
#include "measure/report/measured_html.h"
#include "measure/report/measured_table.h"
#include "measure/report/mesh_maps.h"
#include "measure/report/plane_maps.h"
#include "photometry/lamps/lamp_file.h"

namespace tessera::client {
namespace {

absl::Status write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (file) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(path, " cannot be written"));
}

/// The file of an intensity meter, the first one.
absl::Status write_lamp(const std::string& path, const v1::MeterList& list, const Measured& measured) {
  for (int i = 0; i < list.meters_size(); ++i) {
    if (!list.meters(i).has_intensity()) continue;
    const auto meter = std::ranges::find(measured.meters, list.meters(i).name(), &MeasuredMeter::name);
    if (meter == measured.meters.end()) continue;
    const auto luminaire = luminaire_of(list.meters(i), *meter);
    if (!luminaire.ok()) return luminaire.status();
    const auto text = absl::EndsWithIgnoreCase(path, ".ldt") ? photometry::write_eulumdat(*luminaire)
                                                             : photometry::write_ies(*luminaire);
    return text.ok() ? write_file(path, *text) : text.status();
  }
  return absl::InvalidArgumentError("--lamp-file is of an intensity meter with a name, and there is none");
}

/// Maps of all planes and surfaces, as pictures and as values; surfaces as meshes, too.
absl::Status write_maps(const std::string& folder, const Measured& measured, bool y_up) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (std::size_t m = 0; m < measured.meters.size(); ++m) {
    const MeasuredMeter& meter = measured.meters[m];
    for (std::size_t p = 0; p < meter.planes.size(); ++p) {
      for (const char* const extension : {".png", ".exr"}) {
        const std::string path =
            (std::filesystem::path(folder) / absl::StrCat(m + 1, "-", p + 1, extension)).string();
        if (absl::Status s = write_plane_map(measured, meter, meter.planes[p], {}, path); !s.ok()) return s;
      }
    }
    for (std::size_t p = 0; p < meter.meshes.size(); ++p) {
      for (const char* const extension : {".png", ".exr", ".ply"}) {
        const std::string path =
            (std::filesystem::path(folder) / absl::StrCat(m + 1, "-mesh-", p + 1, extension)).string();
        if (absl::Status s = write_mesh_map(meter, meter.meshes[p], {.maps = {}, .y_up = y_up}, path);
            !s.ok())
          return s;
      }
    }
  }
  return absl::OkStatus();
}

/// The table that was asked for, and the page, of a run or a series.
template <class Figures>
absl::Status write_tables(const FigureFiles& files, const v1::MeterList& list, const Figures& figures) {
  const std::string text = measured_text(figures, {.all_cells = files.all_cells});
  if (files.figures.empty()) std::cout << text;
  absl::Status written;
  if (absl::EndsWithIgnoreCase(files.figures, ".csv"))
    written = write_file(files.figures, measured_csv(figures));
  if (absl::EndsWithIgnoreCase(files.figures, ".json"))
    written = write_file(files.figures, measured_json(figures));
  if (absl::EndsWithIgnoreCase(files.figures, ".txt")) written = write_file(files.figures, text);
  if (files.html.empty()) return written;
  MeasuredReportOptions how;
  how.y_up = list.up() == v1::MeterList::Y;
  written.Update(write_file(files.html, measured_html(figures, how)));
  return written;
}

}  // namespace

absl::Status check_figures_file(const std::string& path) {
  for (const char* const extension : {".csv", ".json", ".txt"})
    if (absl::EndsWithIgnoreCase(path, extension)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("'", path, "': figures are written as .csv, .json or .txt"));
}

absl::Status write_figures(const FigureFiles& files, const v1::MeterList& list, const Measured& measured) {
  absl::Status written = write_tables(files, list, measured);
  if (!files.lamp.empty()) written.Update(write_lamp(files.lamp, list, measured));
  if (!files.maps.empty()) written.Update(write_maps(files.maps, measured, list.up() == v1::MeterList::Y));
  return written;
}

absl::Status write_figures(const FigureFiles& files, const v1::MeterList& list,
                           const MeasuredSeries& series) {
  absl::Status written = write_tables(files, list, series);
  if (!files.lamp.empty())
    written.Update(absl::InvalidArgumentError("--lamp-file is of a scene without a sky, and of no series"));
  for (const MeasuredStep& step : series.steps) {
    if (files.maps.empty()) break;
    const std::string name = absl::StrCat(series.name, "-", short_text(step.value));
    written.Update(write_maps((std::filesystem::path(files.maps) / name).string(), step.measured,
                              list.up() == v1::MeterList::Y));
  }
  return written;
}

}  // namespace tessera::client
