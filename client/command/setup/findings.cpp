#include "command/setup/findings.h"

#include <sys/statvfs.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "base/printable.h"
#include "local/local_farm.h"
#include "net/channel.h"
#include "net/probe.h"
#include "net/tls.h"
#include "net/x509.h"
#include "wire/version.h"

namespace tessera::client {
namespace {

constexpr double kGigabyte = 1e9;

std::string home_folder(const char* variable, const std::string& below) {
  const char* const named = std::getenv(variable);
  if (named != nullptr && *named != '\0') return named;
  const char* const home = std::getenv("HOME");
  return home != nullptr ? absl::StrCat(home, "/", below) : "/";
}

Finding examine_kernels() {
  const std::vector<std::string> isas = local_isas();
  if (!isas.empty()) return {Health::kWell, "kernels", absl::StrJoin(isas, ", "), ""};
  return {Health::kFault, "kernels", "none that this processor can run was found",
          "x86-64 with AVX2 or 64-bit ARM is needed, and lib/libtessera_kernel_*.so beside bin/"};
}

Finding examine_memory() {
  std::ifstream in("/proc/meminfo");
  std::map<std::string, double> gigabytes;
  std::string name, unit;
  for (double kilobytes = 0; in >> name >> kilobytes; std::getline(in, unit))
    gigabytes[name] = kilobytes * 1024 / kGigabyte;
  const double free = gigabytes["MemAvailable:"], all = gigabytes["MemTotal:"];
  const std::string text = absl::StrFormat("%.1f of %.1f GB available", free, all);
  if (free >= 1) return {Health::kWell, "memory", text, ""};
  return {Health::kNote, "memory", text,
          "large scenes will not fit: end other programs, or render on a farm"};
}

/// The disk that a folder is on, or will be.
Finding examine_disk(const std::string& subject, std::string folder) {
  std::error_code error;
  while (!std::filesystem::exists(folder, error) && folder != "/" && !folder.empty())
    folder = std::filesystem::path(folder).parent_path();
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0)
    return {Health::kFault, subject, absl::StrCat(folder, ": cannot be looked at"),
            "check the folder's rights"};
  const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) / kGigabyte;
  const std::string text = absl::StrFormat("%.1f GB free at %s", free, folder);
  if (free >= 2) return {Health::kWell, subject, text, ""};
  return {free >= 0.1 ? Health::kNote : Health::kFault, subject, text, "make room"};
}

std::string date_of(std::chrono::system_clock::time_point time) {
  return absl::FormatTime("%Y-%m-%d", absl::FromChrono(time), absl::UTCTimeZone());
}

Finding examine_certificate(const std::string& path) {
  std::ifstream in(path);
  const std::string pem{std::istreambuf_iterator<char>{in}, {}};
  const net::Certificate certificate = net::certificate_from_pem(pem);
  if (certificate == nullptr)
    return {Health::kFault, "certificates", absl::StrCat(path, " is no certificate"), ""};
  const auto begin = net::begin_of(certificate.get()), end = net::end_of(certificate.get());
  if (!begin || !end) return {Health::kFault, "certificates", absl::StrCat(path, " has no dates"), ""};
  const std::string text = absl::StrCat(path, " (", base::printable(net::name_of(certificate.get())),
                                        "), from ", date_of(*begin), " to ", date_of(*end));
  const auto now = std::chrono::system_clock::now();
  const std::string renew = "renew it on the coordinator's machine: tessera-server --init-tls DIR";
  if (*end < now) return {Health::kFault, "certificates", text + ": it has expired", renew};
  if (*begin > now)
    return {Health::kFault, "certificates", text + ": not valid yet", "set this machine's clock"};
  const bool soon = *end - now < std::chrono::hours(24 * 30);
  return {soon ? Health::kNote : Health::kWell, "certificates", text, soon ? renew : ""};
}

/// Nothing where the coordinator may be called.
std::vector<Finding> examine_port(const ServerOption& server) {
  const absl::StatusOr<base::HostPort> address = base::parse_host_port(server.address);
  if (!address.ok()) {
    return {{Health::kFault, "coordinator", absl::StrCat(server.address, ": ", address.status().message()),
             "tessera config set server HOST:PORT"}};
  }
  const bool encrypted = !server.certificates.empty();
  switch (net::probe(*address, std::chrono::milliseconds(2000))) {
    case net::Speaks::kNobody:
      if (server.address == ServerOption{}.address)
        return {{Health::kNote, "coordinator", absl::StrCat("nobody listens at ", server.address),
                 "`tessera render` needs none; for a farm: tessera config set server HOST:PORT"}};
      return {
          {Health::kFault, "coordinator", absl::StrCat("nobody listens at ", server.address),
           "start tessera-server there, open the port in the firewall, or name another: tessera config set "
           "server HOST:PORT"}};
    case net::Speaks::kTls:
      if (encrypted) return {};
      return {{Health::kFault, "coordinator",
               absl::StrCat(server.address, " speaks TLS, and no certificates are named"),
               "tessera config set tls DIR"}};
    case net::Speaks::kPlain:
      if (!encrypted) return {};
      return {{Health::kFault, "coordinator", absl::StrCat(server.address, " does not speak TLS"),
               "start it with --tls, or leave tls out of the configuration (TESSERA_TLS)"}};
    case net::Speaks::kUnclear:
      return {{Health::kFault, "coordinator",
               absl::StrCat("what listens at ", server.address, " is no coordinator"), "check the port"}};
  }
  return {};
}

Finding examine_clock(double difference_seconds) {
  const std::string text =
      absl::StrFormat("the coordinator's is %+.1f s from this machine's", difference_seconds);
  if (std::abs(difference_seconds) < 30) return {Health::kWell, "clock", text, ""};
  return {Health::kNote, "clock", text, "let both be set by NTP: certificates and tokens depend on the time"};
}

}  // namespace

std::vector<Finding> examine_machine() {
  return {examine_kernels(), examine_memory(),
          examine_disk("disk of the cache", home_folder("XDG_CACHE_HOME", ".cache")),
          examine_disk("disk of the data", home_folder("XDG_STATE_HOME", ".local/state"))};
}

std::vector<Finding> examine_certificates(const std::string& folder) {
  if (folder.empty()) return {{Health::kWell, "certificates", "none: no encryption, this machine only", ""}};
  std::vector<Finding> findings;
  if (const absl::Status status = net::check_certificates(folder); !status.ok())
    findings.push_back({Health::kFault, "certificates", std::string{status.message()},
                        "docs/farm.md says how they are made; tessera config set tls DIR"});
  for (const char* const file : {net::kCertificateFile, net::kTrustedFile}) {
    const std::string path = absl::StrCat(folder, "/", file);
    if (std::error_code error; std::filesystem::exists(path, error))
      findings.push_back(examine_certificate(path));
  }
  return findings;
}

std::vector<Finding> examine_farm(const ServerOption& server, std::stop_token stop) {
  std::vector<Finding> findings = examine_port(server);
  if (!findings.empty()) return findings;
  const auto farm = connect(server, /*quiet=*/true);
  if (!farm.ok()) return {{Health::kFault, "coordinator", std::string{farm.status().message()}, ""}};
  const auto before = std::chrono::system_clock::now();
  const absl::StatusOr<v1::ListWorkersResponse> members = (*farm)->members(std::move(stop));
  if (!members.ok()) {
    return {{Health::kFault, "coordinator", base::printable(std::string{members.status().message()}),
             "client, coordinator and workers have to come from one release"}};
  }
  const std::string own = wire::build_version(), theirs = base::printable(members->build());
  const bool same = theirs == own;
  findings.push_back(
      {same ? Health::kWell : Health::kFault, "coordinator",
       absl::StrCat(server.address, ", version ", theirs.empty() ? "unknown" : theirs, ", client ", own),
       same ? "" : "install the same release on all machines"});
  // The answer was made between call and return.
  const auto middle = before + (std::chrono::system_clock::now() - before) / 2;
  const double here = std::chrono::duration<double>(middle.time_since_epoch()).count();
  if (members->unix_time_ms() != 0)
    findings.push_back(examine_clock(static_cast<double>(members->unix_time_ms()) * 1e-3 - here));
  std::map<std::string, int> builds;
  for (const v1::WorkerStatus& worker : members->workers()) ++builds[base::printable(worker.build())];
  if (builds.empty()) {
    findings.push_back({Health::kNote, "workers", "none", "start tessera-worker --server " + server.address});
  }
  for (const auto& [build, count] : builds) {
    findings.push_back({build == theirs ? Health::kWell : Health::kFault, "workers",
                        absl::StrCat(count, " of version ", build),
                        build == theirs ? "" : "install the coordinator's release on them"});
  }
  return findings;
}

}  // namespace tessera::client
