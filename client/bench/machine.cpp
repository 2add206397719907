#include "bench/machine.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/process.h"

namespace tessera::client {
namespace {

std::string processor_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

unsigned usable_processors() {
  cpu_set_t set;
  if (::sched_getaffinity(0, sizeof(set), &set) != 0) return 0;
  return static_cast<unsigned>(CPU_COUNT(&set));
}

double seconds_of(int who) {
  rusage usage{};
  ::getrusage(who, &usage);
  return cpu_seconds(usage);
}

}  // namespace

MachineWatch::Times MachineWatch::now() {
  Times times{.busy = 0,
              .own = seconds_of(RUSAGE_SELF) + seconds_of(RUSAGE_CHILDREN),
              .wall = std::chrono::steady_clock::now()};
  // user nice system idle iowait irq softirq steal, in ticks of all processors together [proc(5)].
  std::ifstream file("/proc/stat");
  std::string name;
  file >> name;
  const auto ticks = static_cast<double>(::sysconf(_SC_CLK_TCK));
  for (int i = 0; i < 8; ++i) {
    double value = 0;
    if (file >> value && i != 3 && i != 4) times.busy += value / ticks;
  }
  return times;
}

MachineWatch::MachineWatch() : start_(now()) {
  machine_.processor_model = processor_model();
  machine_.processors = usable_processors();
  if (double load[1]; ::getloadavg(load, 1) == 1) machine_.load = load[0];
}

Machine MachineWatch::machine() const {
  Machine machine = machine_;
  const Times end = now();
  const double wall = std::chrono::duration<double>(end.wall - start_.wall).count();
  if (wall > 0) machine.others = std::max(0.0, (end.busy - start_.busy - (end.own - start_.own)) / wall);
  return machine;
}

std::string to_text(const Machine& machine) {
  return absl::StrCat(machine.processor_model.empty() ? "processor not known" : machine.processor_model,
                      absl::StrFormat(", %u processors; load %.2f before, others kept %.2f of them busy",
                                      machine.processors, machine.load, machine.others),
                      machine.is_loaded()
                          ? "\nLOADED: other work stretches CPU seconds; only ratios within this run count"
                          : "");
}

}  // namespace tessera::client
