// The automaton against a matcher that knows nothing of it: paths of up to three events are written as
// characters, and held against regular expressions of these characters.
#include "layers/automaton.h"

#include <gtest/gtest.h>

#include <regex>

#include "layers/expression.h"

namespace tessera::test::automaton {
namespace {

using layers::Alphabet;
using layers::Automaton;
using layers::Direction;
using layers::Layer;

/// The surfaces: one without names, the ball of gold, the ball of clay, the floor of clay. Lights: one
/// without a name, and the key light.
const Alphabet kAlphabet = {
    .surfaces = {{{}, {}}, {{"ball"}, {"gold"}}, {{"ball"}, {"clay"}}, {{"floor"}, {"clay"}}},
    .lights = {{}, {"key"}}};

// One character a point: the eye is @, events are a to g at the first surface (diffuse, glossy, specular
// reflection; the same of transmission; volume), then h to n, o to u, A to G; lights are 1 to 4 without a
// name (lamp, surface, background, medium) and 5 to 8.
char event_character(int label, int event) {
  return label < 3 ? static_cast<char>('a' + 7 * label + event) : static_cast<char>('A' + event);
}
char light_character(int label, int source) { return static_cast<char>('1' + 4 * label + source); }

struct Case {
  const char* expression;
  const char* pattern;  // a regular expression for the path from the camera
};

const Case kCases[] = {
    {"LE", "@[1-8]"},
    {"CL", "@[1-8]"},
    {"OE", "@[26]"},
    {"CB", "@[37]"},
    {"LDE", "@[adhkorAD][1-8]"},
    {"L.E", "@[a-uA-G][1-8]"},
    {"L.*E", "@[a-uA-G]*[1-8]"},
    {"L(S|D)*E", "@[acdfhjkmoqrtACDF]*[1-8]"},
    {"LS+DE", "@[adhkorAD][cfjmqtCF]+[1-8]"},
    {"CDS+L", "@[adhkorAD][cfjmqtCF]+[1-8]"},
    {"LDS?E", "@[cfjmqtCF]?[adhkorAD][1-8]"},
    {"L.{2}E", "@[a-uA-G]{2}[1-8]"},
    {"L.{2,}E", "@[a-uA-G]{2,}[1-8]"},
    {"L(DG){0,2}E", "@([beilpsBE][adhkorAD]){0,2}[1-8]"},
    {"L((D?)S*)+E", "@([cfjmqtCF]*[adhkorAD]?)+[1-8]"},
    {"L(D|GS)(V|T)*E", "@[gnud-fk-mr-tD-G]*([adhkorAD]|[cfjmqtCF][beilpsBE])[1-8]"},
    {"C<RD>.*<L.>", "@[ahoA][a-uA-G]*[1-8]"},
    {"C<TS>*<RG>L", "@[fmtF]*[bipB][1-8]"},
    {"C<R>L", "@[a-ch-jo-qA-C][1-8]"},
    {"C<.S>L", "@[cfjmqtCF][1-8]"},
    {"C<V.>+O", "@[gnuG]+[26]"},
    {"C[DS]*B", "@[acdfhjkmoqrtACDF]*[37]"},
    {"C[^DV]+L", "@[bcefijlmpqstBCEF]+[1-8]"},
    {"C[^<RD>S]L", "@[bdegiklnprsuBDEG][1-8]"},
    {"C<[RT]D>L", "@[adhkorAD][1-8]"},
    {"C<[^T]D>L", "@[ahoA][1-8]"},
    {"C<R[^D]>L", "@[bcijpqBC][1-8]"},
    {"C<[^LOBV]>L", "@[a-fh-mo-tA-F][1-8]"},
    {"C(D|(GS|T))L", "@([adhkorAD]|[beilpsBE][cfjmqtCF]|[d-fk-mr-tD-F])[1-8]"},
    {"C<RD'ball'>L", "@[ho][1-8]"},
    {"C<RD'clay'>L", "@[oA][1-8]"},
    {"C<RD['gold' 'floor']>L", "@[hA][1-8]"},
    {"C<.D[^'ball']>L", "@[adAD][1-8]"},
    {"C<RDo'ball'm'clay'>L", "@o[1-8]"},
    {"C<RDm'ball'>L", "@X"},
    {"C.*<L.'key'>", "@[a-uA-G]*[5-8]"},
    {"C.*<L.[^'key']>", "@[a-uA-G]*[1-4]"},
    {"C.*<O'key'>", "@[a-uA-G]*6"},
    {"<B.'key'><.S'ball'>*E", "@[jmqt]*7"},
    {"C<..'ball'>*L", "@[h-u]*[1-8]"},
};

/// Calls f(events, from the camera) for every path of up to two events, and every third of those that go on
/// from there, up to `most`.
template <class F>
void for_each_path(int most, F&& f) {
  std::vector<std::int32_t> events;
  const std::int32_t kinds = 4 * layers::kEvents;
  const auto go_on = [&](auto&& self, int left) -> void {
    f(events);
    if (left == 0) return;
    const std::int32_t step = events.size() < 2 ? 1 : 3;
    for (std::int32_t k = static_cast<std::int32_t>(events.size()) % step; k < kinds; k += step) {
      events.push_back(k / layers::kEvents * layers::kEventStride + k % layers::kEvents);
      self(self, left - 1);
      events.pop_back();
    }
  };
  go_on(go_on, most);
}

std::uint32_t layers_from_camera(const Automaton& automaton, const std::vector<std::int32_t>& events,
                                 std::int32_t source) {
  std::int32_t state = automaton.begin[0];
  for (const std::int32_t event : events)
    state = automaton.next[static_cast<std::size_t>(state * automaton.events + event)];
  return static_cast<std::uint32_t>(
      automaton.layers[static_cast<std::size_t>(state * automaton.ends + source)]);
}

std::uint32_t layers_from_light(const Automaton& automaton, const std::vector<std::int32_t>& events,
                                std::int32_t source) {
  std::int32_t state = automaton.begin[static_cast<std::size_t>(source)];
  for (auto event = events.rbegin(); event != events.rend(); ++event)
    state = automaton.next[static_cast<std::size_t>(state * automaton.events + *event)];
  return static_cast<std::uint32_t>(automaton.layers[static_cast<std::size_t>(state)]);
}

/// The first `meeting` events are read from the camera, the others from the light.
std::uint32_t layers_from_both(const Automaton& from_camera, const Automaton& from_lights,
                               const std::vector<std::int32_t>& joined,
                               const std::vector<std::int32_t>& events, std::size_t meeting,
                               std::int32_t source) {
  std::int32_t eye = from_camera.begin[0], light = from_lights.begin[static_cast<std::size_t>(source)];
  for (std::size_t i = 0; i < meeting; ++i)
    eye = from_camera.next[static_cast<std::size_t>(eye * from_camera.events + events[i])];
  for (std::size_t i = events.size(); i > meeting; --i)
    light = from_lights.next[static_cast<std::size_t>(light * from_lights.events + events[i - 1])];
  return static_cast<std::uint32_t>(joined[static_cast<std::size_t>(eye * from_lights.states + light)]);
}

std::string written(const std::vector<std::int32_t>& events, std::int32_t source) {
  std::string path = "@";
  for (const std::int32_t event : events)
    path += event_character(event / layers::kEventStride, event % layers::kEventStride);
  return path + light_character(source / layers::kSources, source % layers::kSources);
}

TEST(LayerAutomaton, AgreesWithRegularExpressionsOnEveryPathFromBothEnds) {
  const std::vector<Case> cases(std::begin(kCases), std::end(kCases));
  std::size_t compared = 0, held = 0;
  // The most at a time that a picture may have, so that all of an automaton is tried.
  for (std::size_t first = 0; first < cases.size(); first += layers::kMaxLayers) {
    const std::size_t count = std::min(cases.size() - first, layers::kMaxLayers);
    std::vector<Layer> asked;
    std::vector<std::regex> patterns;
    for (std::size_t i = 0; i < count; ++i) {
      asked.push_back({"a" + std::to_string(i), cases[first + i].expression});
      patterns.emplace_back(cases[first + i].pattern, std::regex::optimize);
    }
    const auto forward = layers::compile(asked, kAlphabet, Direction::kFromCamera);
    const auto backward = layers::compile(asked, kAlphabet, Direction::kFromLights);
    ASSERT_TRUE(forward.ok() && backward.ok()) << forward.status() << backward.status();
    const std::vector<std::int32_t> joined = layers::layers_of_joins(*forward, *backward);
    int turn = 0;
    for_each_path(3, [&](const std::vector<std::int32_t>& events) {
      // All lights of short paths, one in turn of longer ones.
      for (std::int32_t source = 0; source < 8; ++source) {
        if (events.size() > 1 && source != turn % 8) continue;
        const std::string path = written(events, source);
        const std::uint32_t found = layers_from_camera(*forward, events, source);
        ASSERT_EQ(found, layers_from_light(*backward, events, source)) << path;
        for (std::size_t meeting = 0; meeting <= events.size(); ++meeting)
          ASSERT_EQ(found, layers_from_both(*forward, *backward, joined, events, meeting, source)) << path;
        for (std::size_t i = 0; i < count; ++i) {
          const bool wanted = std::regex_match(path, patterns[i]);
          ASSERT_EQ((found >> i & 1) != 0, wanted) << cases[first + i].expression << " and " << path;
          ++compared;
          held += wanted;
        }
      }
      ++turn;
    });
  }
  EXPECT_GT(compared, 200'000u);
  EXPECT_GT(held, 20'000u);
}

TEST(LayerAutomaton, KnowsLongPaths) {
  const std::vector<Layer> asked = {{"a", "L.{9}E"}, {"b", "LS+DE"}, {"c", "L(DS){3,5}E"}};
  const auto automaton = layers::compile(asked, {}, Direction::kFromCamera);
  ASSERT_TRUE(automaton.ok());
  const std::int32_t d = 0, s = 2;
  EXPECT_EQ(layers_from_camera(*automaton, std::vector<std::int32_t>(9, d), 0), 1u);
  EXPECT_EQ(layers_from_camera(*automaton, std::vector<std::int32_t>(10, d), 0), 0u);
  EXPECT_EQ(layers_from_camera(*automaton, {d, s, s, s, s, s, s, s, s, s, s, s}, 0), 2u);
  EXPECT_EQ(layers_from_camera(*automaton, {s, d, s, d, s, d, s, d}, 0), 4u);
  EXPECT_EQ(layers_from_camera(*automaton, {s, d, s, d, s, d, s, d, s, d, s, d}, 0), 0u);
}

TEST(LayerAutomaton, IsOneForBothNotations) {
  const auto heckbert = layers::compile(std::vector<Layer>{{"a", "LS+DE"}, {"b", "L(S|D)*GE"}}, kAlphabet,
                                        Direction::kFromCamera);
  const auto osl = layers::compile(std::vector<Layer>{{"a", "C<.D><.S>+<L.>"}, {"b", "CG[SD]*L"}}, kAlphabet,
                                   Direction::kFromCamera);
  ASSERT_TRUE(heckbert.ok() && osl.ok());
  EXPECT_EQ(heckbert->states, osl->states);
  for_each_path(3, [&](const std::vector<std::int32_t>& events) {
    ASSERT_EQ(layers_from_camera(*heckbert, events, 1), layers_from_camera(*osl, events, 1));
  });
}

TEST(LayerAutomaton, IsMinimal) {
  const auto states = [](std::vector<Layer> asked) {
    return layers::compile(asked, {}, Direction::kFromCamera)->states;
  };
  EXPECT_EQ(states({{"all", "L.*E"}}), 1);
  EXPECT_EQ(states({{"all", "L(.|..)*E"}}), 1);
  EXPECT_EQ(states({{"seen", "LE"}}), 2);  // and the one of all else
  EXPECT_EQ(states({{"seen", "LE"}, {"lit", "L.E"}}), 3);
  EXPECT_EQ(states({{"caustics", "LS+DE"}}), 4);  // begun, D, DS+, none
}

}  // namespace
}  // namespace tessera::test::automaton
