// tessera settings [NAME]: what `--set` takes.
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/frames/frames.h"
#include "command/interrupt.h"
#include "command/render_options.h"
#include "command/report/output.h"
#include "command/settings_page.h"

namespace tessera::client {

void add_settings_command(CommandLine& line) {
  auto name = std::make_shared<std::string>();
  Command command = line.add_command("settings", "List the settings that --set takes, or tell of one");
  command.add("NAME", *name, "a setting, as in path-sharing; or those of an integrator, as in mlt");
  auto document = std::make_shared<bool>();
  command.add_flag("--document", *document, "all of them as docs/settings.md");
  command.example("tessera settings");
  command.example("tessera settings integrator");
  command.example("tessera settings mlt");
  command.does([name, document](Interrupt&) {
    if (*document) {
      std::cout << settings_document();
      return static_cast<int>(kDone);
    }
    RenderOptions options;
    const auto define = [&](options::Command& render) {
      define_render_options(render, options);
      define_frame_options(render, options);
    };
    const absl::StatusOr<std::string> text = options::settings_of(define, *name);
    if (!text.ok()) return report(kUsage, std::string{text.status().message()});
    std::cout << *text;
    return static_cast<int>(kDone);
  });
}

}  // namespace tessera::client
