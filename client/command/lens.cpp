// tessera lens FILE: what a lens is like.
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/lens/lens_report.h"
#include "command/report/table.h"
#include "import/lens/lens_file.h"
#include "plot/log_log_plot.h"

namespace tessera::client {
namespace {

struct LensOptions {
  std::string file;
  double focus_mm = std::numeric_limits<double>::infinity();
  double f_number = 0;
  double film_diagonal = 43.27;
  std::string drawing;
  bool json = false;
};

/// "2m", "80cm", "500mm", "infinity".
absl::Status read_length(const std::string& text, double& mm) {
  if (text == "infinity" || text == "inf") {
    mm = std::numeric_limits<double>::infinity();
    return absl::OkStatus();
  }
  const std::size_t end = text.find_last_of("0123456789.") + 1;
  const std::string unit = text.substr(end);
  const double factor = unit == "m" ? 1000 : unit == "cm" ? 10 : unit == "mm" ? 1 : 0;
  double value = 0;
  if (factor == 0 || !absl::SimpleAtod(text.substr(0, end), &value) || !(value > 0) ||
      !std::isfinite(value)) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", text, "' is no distance: expected one like 2m, 80cm, 500mm or infinity"));
  }
  mm = value * factor;
  return absl::OkStatus();
}

absl::Status read_stop(const std::string& text, double& f_number) {
  const std::string number = text.rfind("f/", 0) == 0 ? text.substr(2) : text;
  if (absl::SimpleAtod(number, &f_number) && f_number > 0 && std::isfinite(f_number)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("'", text, "' is no f-number"));
}

int run(const LensOptions& options) {
  if (!options.drawing.empty()) {
    if (auto s = check_plot_path(options.drawing); !s.ok()) return report(kUsage, std::string{s.message()});
  }
  const auto file = read_lens_file(options.file);
  if (!file.ok()) return report(kUsage, std::string{file.status().message()});
  for (const std::string& warning : file->warnings) std::cerr << warning << '\n';
  optics::LensUse use;
  use.focus = options.focus_mm, use.f_number = options.f_number;
  std::vector<optics::Fault> faults;
  const auto lens = optics::LensSystem::focus(file->lens, use, faults);
  if (!lens) return report(kUsage, std::string{status_of(faults, options.file).message()});
  const LensReport facts = report_of(*lens, options.film_diagonal);
  std::cout << (options.json ? json_of(facts) + "\n" : text_of(facts, table_width(1)));
  if (options.drawing.empty()) return kDone;
  const auto written = write_lens_drawing(drawing_of(*lens, options.film_diagonal), options.drawing);
  return written.ok() ? kDone : report(kUsage, std::string{written.message()});
}

}  // namespace

void add_lens_command(CommandLine& line) {
  auto options = std::make_shared<LensOptions>();
  Command command = line.add_command("lens", "Tell what a lens is like, by rays through its surfaces");
  command.add("FILE", options->file, "the lens: .textproto, .dat (pbrt) or .zmx (Zemax)").required();
  command
      .add_read_by(
          "--focus", [options](const std::string& text) { return read_length(text, options->focus_mm); },
          "distance from the film of what is sharp: 2m, 80cm, 500mm; else infinity")
      .type_name("DISTANCE");
  command
      .add_read_by(
          "--stop", [options](const std::string& text) { return read_stop(text, options->f_number); },
          "f-number; else the lens's own")
      .type_name("NUMBER");
  command.add("--film", options->film_diagonal, "diagonal of the film in mm")
      .in_range(0.1, 10000)
      .with_default();
  command.add("--svg", options->drawing, "draw the lens with rays, as .svg or .png").type_name("FILE");
  command.add_flag("--json", options->json, "as JSON, with the spots");
  command.example("tessera lens --focus 2m --stop 2.8 scenes/lenses/double-gauss.textproto");
  command.does([options](Interrupt&) { return run(*options); });
}

}  // namespace tessera::client
