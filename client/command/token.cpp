// tessera token
#include <charconv>
#include <iostream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "base/address.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct TokenOptions {
  ServerOption server;
  std::chrono::seconds lifetime{std::chrono::hours{1}};
  std::uint32_t uses = 1;
  bool web = false;
};

/// "90s", "30m", "1h", "2d".
absl::Status read_lifetime(const std::string& text, std::chrono::seconds& lifetime) {
  std::int32_t number = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit{rest, text.data() + text.size()};
  std::int64_t seconds = 0;
  if (unit == "s") seconds = 1;
  if (unit == "m") seconds = 60;
  if (unit == "h") seconds = 3600;
  if (unit == "d") seconds = 86400;
  if (error != std::errc() || seconds == 0 || number <= 0) {
    return absl::InvalidArgumentError("expected a time such as 30m, 1h or 2d");
  }
  lifetime = std::chrono::seconds{number * seconds};
  return absl::OkStatus();
}

/// The address to open: the server's own, where the page listens on every address of its machine.
std::string page_address(const v1::MakeWebTokenResponse& page, const std::string& server) {
  std::string address = page.address();
  auto web = base::parse_host_port(address);
  const auto called = base::parse_host_port(server);
  if (web.ok() && called.ok() && (web->host == "0.0.0.0" || web->host == "::")) {
    web->host = called->host;
    address = web->to_string();
  }
  return absl::StrCat(page.encrypted() ? "https" : "http", "://", address, "/",
                      page.token().empty() ? "" : "#login=", page.token());
}

int print_page(FarmClient& farm, const TokenOptions& options, Interrupt& interrupt) {
  const auto page = farm.make_web_token(options.lifetime, interrupt.token());
  if (!page.ok()) return report_farm_error(page.status(), options.server);
  std::cout << page_address(*page, options.server.address) << '\n';
  const auto web = base::parse_host_port(page->address());
  const auto called = base::parse_host_port(options.server.address);
  if (web.ok() && called.ok() && base::is_loopback(web->host) && !base::is_loopback(called->host)) {
    std::cerr << "the page is for browsers on " << called->host << "; from here: ssh -L " << web->port << ":"
              << page->address() << " " << called->host << '\n';
  }
  return kDone;
}

int run(const TokenOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  if (options.web) return print_page(**farm, options, interrupt);
  const absl::StatusOr<std::string> token =
      (*farm)->make_join_token(options.lifetime, options.uses, interrupt.token());
  if (!token.ok()) return report_farm_error(token.status(), options.server);
  std::cout << *token << '\n';
  return kDone;
}

}  // namespace

void add_token_command(CommandLine& line) {
  auto options = std::make_shared<TokenOptions>();
  Command command =
      line.add_command("token", "Print a token with which workers join the farm (tessera-worker --join)");
  command.add_flag("--web", options->web,
                   "print instead the address of the farm's web page, with a token that logs in once");
  command
      .add_read_by(
          "--for", [options](const std::string& text) { return read_lifetime(text, options->lifetime); },
          "how long it is accepted: 30m, 1h, 2d (default: 1h)")
      .type_name("TIME");
  command.add("--uses", options->uses, "how many workers may join with it").with_default();
  define_server_option(command, options->server);
  command.example("tessera token --for 2h --uses 20 --tls ~/farm-tls/admin");
  command.example("tessera token --web --tls ~/farm-tls/client-$USER");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
