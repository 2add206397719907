// tessera watch ID
#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/jobs/follow.h"
#include "command/jobs/job_selection.h"
#include "command/jobs/on_done.h"
#include "command/report/job_table.h"
#include "command/server_option.h"
#include "display/half_blocks.h"

namespace tessera::client {
namespace {

struct WatchOptions {
  ServerOption server;
  std::string job_id;
  std::string on_done;
  bool json = false;
  bool preview = false;
};

/// The picture as it grows, above the line of progress.
class Preview {
 public:
  explicit Preview(const v1::JobSpec& spec)
      : crop_(crop_of(spec)), cells_(cells_for(crop_)), image_(crop_, cells_.first, cells_.second) {}

  void add(const wire::TileResult& result) {
    if (!image_.add(result).ok()) return;
    // A terminal takes a few pictures a second.
    if (on_terminal_ && Clock::now() - drawn_ >= std::chrono::milliseconds{500}) draw();
  }
  void clear() { image_.clear(); }
  void draw() {
    if (on_terminal_) std::cout << (drawn_ == Clock::time_point{} ? "\x1b[2J\x1b[H" : "\x1b[H");
    std::cout << half_blocks(image_) << std::flush;
    drawn_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;

  static std::pair<std::int32_t, std::int32_t> cells_for(const Window& crop) {
    winsize size{};
    const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    if (!known) return half_block_cells(crop, 80, 38);
    return half_block_cells(crop, size.ws_col, size.ws_row - 2);  // progress has a line, and the cursor one
  }

  const Window crop_;
  const std::pair<std::int32_t, std::int32_t> cells_;
  const bool on_terminal_ = ::isatty(STDOUT_FILENO) == 1;
  GrowingImage image_;
  Clock::time_point drawn_{};
};

int run(const WatchOptions& options, Interrupt& interrupt) {
  const std::stop_token stop = interrupt.token();
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const auto id = find_job_id(**farm, options.job_id, stop);
  if (!id.ok()) return report_farm_error(id.status(), options.server);
  const auto job = (*farm)->job(*id, stop);
  if (!job.ok()) return report_farm_error(job.status(), options.server);
  std::optional<Preview> preview;
  FollowOptions how;
  if (options.preview) {
    preview.emplace(job->spec());
    how.show = [&preview](const wire::TileResult& result) { preview->add(result); };
    how.show_anew = [&preview] { preview->clear(); };
  }
  const auto status = follow_progress(**farm, *id, job->spec(), how, stop);
  if (preview) preview->draw();
  if (!status.ok()) return report_farm_error(status.status(), options.server);
  if (options.json) std::cout << to_json(*status) << '\n';
  return OnDone{options.on_done}.run(*status, "", report_end(*status));
}

}  // namespace

void add_watch_command(CommandLine& line) {
  auto options = std::make_shared<WatchOptions>();
  Command command = line.add_command("watch", "Show a job's progress until it ends");
  command.add("ID", options->job_id, "the job, or a unique beginning of its id").required();
  define_server_option(command, options->server);
  command.add_flag("--preview", options->preview,
                   "draw the picture as it grows, for a terminal with 24-bit colours");
  command.add_flag("--json", options->json, "the final status as JSON");
  define_on_done_option(command, options->on_done);
  command.example("tessera watch 4f0c2a11");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
