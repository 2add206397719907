// Photometric files for tests.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/lamps/luminaire.h"

namespace tessera::photometry {

/// A file as it was read, with the warnings.
struct ReadLamp {
  absl::StatusOr<Luminaire> luminaire = absl::InternalError("");
  std::vector<std::string> warnings;
};
inline ReadLamp read_lamp(const std::string& text, const std::string& name,
                          const TiltFiles& tilt_files = nullptr) {
  ReadLamp result;
  result.luminaire = read_lamp_file(text, {.name = name, .tilt_files = tilt_files}, result.warnings);
  return result;
}

/// `text` with the first `from` replaced.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A downlight: the same in all planes, 800 cd at gamma 0, nothing from 60 degrees on.
inline std::string symmetric_ies() {
  return "IESNA:LM-63-2002\n"
         "[TEST] T-1\n"
         "[TESTLAB] A bench\n"
         "[ISSUEDATE] 2026-11-30\n"
         "[MANUFAC] Lamps and sons\n"
         "[LUMINAIRE] Downlight with\n"
         "[MORE] a wide reflector\n"
         "TILT=NONE\n"
         "1 -1 1 7 1 1 2 -0.1 -0.1 0\n"
         "1 1 12.5\n"
         "0 15 30 45 60 75 90\n"
         "0\n"
         "800 760.5 600 300 0 0 0\n";
}

/// A panel that is the same in all quadrants; in feet, with relative photometry, a ballast and tilt factors.
inline std::string quadrant_ies() {
  return "IESNA:LM-63-1995\r\n"
         "[TEST] Q-2\r\n"
         "TILT=INCLUDE\r\n"
         "1\r\n"
         "3\r\n"
         "0 45 90\r\n"
         "1.0 0.95 0.9\r\n"
         "2 1000 2.5 5 3 1 1 0.5 2 0.1\r\n"
         "0.9 0.98 60\r\n"
         "0 22.5 45 67.5 90\r\n"
         "0 45 90\r\n"
         "200 190 150 80 0\r\n"
         "200 180 130 60 0\r\n"
         "200 170 110 40 0\r\n";
}

/// A wall washer, the same on both sides of plane C0, of 1986: text without keywords, commas.
inline std::string bilateral_ies() {
  return "A wall washer\n"
         "of some maker\n"
         "TILT=NONE\n"
         "1,1200,1,4,5,1,2,0.2,0.2,0\n"
         "1,1,20\n"
         "0,30,60,90\n"
         "0,45,90,135,180\n"
         "300,500,400,100\n"
         "300,420,300,80\n"
         "300,250,120,40\n"
         "300,150,60,10\n"
         "300,120,30,0\n";
}

/// A street light without any symmetry, upward light, too.
inline std::string full_ies() {
  std::string text =
      "IES:LM-63-2019\n[TEST] F-4\n[_LUMENS] none\nTILT=NONE\n1 -1 1 7 9 1 2 0.3 0.5 0.1\n1 1.00001 80\n";
  text += "0 30 60 90 120 150 180\n0 45 90 135 180 225 270 315 360\n";
  for (int plane = 0; plane < 9; ++plane) {
    for (int polar = 0; polar < 7; ++polar) {
      const double c = 45 * plane * std::numbers::pi / 180, gamma = 30 * polar * std::numbers::pi / 180;
      const double value = 500 + 200 * std::sin(gamma) * std::cos(c - 0.4) + 150 * std::cos(gamma);
      // Three digits, as measured; plane 360 is plane 0.
      absl::StrAppend(&text, polar > 0 ? " " : "", std::round(value * 10) / 10);
    }
    text += "\n";
  }
  return text;
}

/// A floodlight in B planes, or a headlight in A planes: a beam 40 degrees wide and 20 high.
inline std::string beam_ies(int type) {
  std::string text =
      absl::StrCat("IES:LM-63-2019\nTILT=NONE\n1 -1 1 5 9 ", type, " 2 0 0 0\n1 1 100\n-20 -10 0 10 20\n");
  text += "-40 -30 -20 -10 0 10 20 30 40\n";
  for (int h = -40; h <= 40; h += 10) {
    for (int v = -20; v <= 20; v += 10) {
      const double value = 1000 * std::exp(-h * h / 800.0 - v * v / 200.0) * (1 + 0.004 * h + 0.01 * v);
      absl::StrAppend(&text, std::round(std::max(0.0, value)), " ");
    }
    text += "\n";
  }
  return text;
}

/// A table of C planes of any function of angles in degrees.
template <class F>
Luminaire luminaire_of(F&& candelas, double plane_step, double polar_step, double last_plane = 360,
                       double last_polar = 180) {
  Luminaire l;
  for (double c = 0; c <= last_plane; c += plane_step) l.plane_degrees.push_back(c);
  for (double gamma = 0; gamma <= last_polar; gamma += polar_step) l.polar_degrees.push_back(gamma);
  for (const double c : l.plane_degrees) {
    for (const double gamma : l.polar_degrees) l.values.push_back(candelas(c, gamma));
  }
  return l;
}

/// An EULUMDAT file of 24 planes and gamma from 0 to 90 in steps of 10 with this symmetry.
inline std::string eulumdat(int symmetry, double output_ratio = 0, const std::string& end = "\r\n") {
  std::string text;
  const auto line = [&](const auto& value) { absl::StrAppend(&text, value, end); };
  line("Lamps and sons");
  line(symmetry == 1 ? 1 : 3);
  line(symmetry);
  for (const int value : {24, 15, 10, 10}) line(value);
  for (const char* const label : {"L-5", "Louvre", "4711", "louvre.ldt", "30.11.2026 / me"}) line(label);
  for (const int value : {1200, 300, 80, 1100, 250, 0, 0, 0, 0}) line(value);
  line(100);
  line(output_ratio);
  line("1.0");
  line(0);
  line(1);
  line(2);
  line("T16 28 W");
  line(5200);
  line("840");
  line("1B");
  line("62,5");
  for (int i = 0; i < 10; ++i) line(0.5 + 0.04 * i);
  for (int c = 0; c < 360; c += 15) line(c);
  for (int gamma = 0; gamma <= 90; gamma += 10) line(gamma);
  const int first = symmetry == 3 ? 18 : 0, count = symmetry == 0   ? 24
                                                    : symmetry == 1 ? 1
                                                    : symmetry == 4 ? 7
                                                                    : 13;
  for (int i = 0; i < count; ++i) {
    const double c = 15 * (first + i) * std::numbers::pi / 180;
    for (int gamma = 0; gamma <= 90; gamma += 10) {
      const double cosine = std::cos(gamma * std::numbers::pi / 180),
                   sine = std::sin(gamma * std::numbers::pi / 180);
      const double lobe = symmetry == 0   ? std::cos(c - 0.7)
                          : symmetry == 2 ? std::cos(c)
                          : symmetry == 3 ? std::sin(c)
                          : symmetry == 4 ? std::cos(2 * c)
                                          : 0;
      line(std::round(10 * 250 * cosine * (1 + 0.4 * sine * lobe)) / 10);
    }
  }
  return text;
}

}  // namespace tessera::photometry
