// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The one place where the words of the outputs are explained: octant explain, the guide's page of words, the
// man page.
#include "apps/octant/help/glossary.h"

#include <algorithm>
#include <cctype>
#include <iterator>

#include <fmt/format.h>

namespace octant::app {
namespace {

using enum GlossaryKind;

std::string plain(std::string_view word) {
  std::string out;
  for (const char c : word)
    out += c == '_' || c == '-' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  while (!out.empty() && out.back() == ' ') out.pop_back();
  const std::size_t first = out.find_first_not_of(' ');
  out.erase(0, std::min(first, out.size()));
  constexpr std::string_view kExitWord = "exit ";
  return out.starts_with(kExitWord) ? out.substr(kExitWord.size()) : out;
}

const char* heading(GlossaryKind kind) {
  switch (kind) {
    case kTerm: return "Terms";
    case kGrade: return "Grades of a verdict";
    case kReason: return "Why an arrival is left out, why there is no fix, what contradicts";
    case kExit: return "Exit codes";
  }
  return "";
}

constexpr GlossaryTerm kGlossary[] = {
    {kTerm, "alarm", "alarms, cusum, trend, forecast, false alarm",
     "History draws each number over the visits, less what the earlier ones foretell; sums of what is left "
     "(CUSUM) that pass their limit are an alarm. One that is false comes once in a hundred visits."},
    {kTerm, "amplitude", "amplitude_v, level_dbm",
     "How loud an arrival was. It tells how late a weak pulse crosses the threshold, and whether a beacon is "
     "dirty."},
    {kTerm, "arrival", "arrivals, used, left out, rejected",
     "One time of flight between one beacon and one receiver: a row of tof.csv. An arrival is used, or "
     "left out with "
     "a reason (late, early, ...). Some per cent left out is normal indoors; a beacon that loses half of "
     "its own "
     "stands elsewhere, or is seen through echoes."},
    {kTerm, "beacon", "anchor, transmitter, node",
     "A device that is fixed to the building. It may send or receive: the equations are the same."},
    {kTerm, "change", "changes, changed, beacon_moved, moved",
     "What differs from an earlier deployment beyond chance and drift: a place, a delay, a receiver, the "
     "speed, labels."},
    {kTerm, "clock jump", "clock jumps, resolution",
     "A step in the times of flight of all beacons at once, as of a clock that was set; the smallest step in "
     "which "
     "they are counted is the resolution."},
    {kTerm, "control point", "control points, held fixed, control, fixed",
     "A beacon whose place was surveyed: sigma_m: 0 in the site file. It is held fixed, and everything "
     "else is found "
     "relative to it, so its error goes into all others. Three that do not stand in one line fix the map."},
    {kTerm, "correlated noise", "correlation, stride, white sigma, white_sigma_m",
     "Errors that many arrivals share (the air's temperature, a wall's echo) do not average out. Octant "
     "estimates "
     "them from the residuals and states sigmas that hold with them; white_sigma_m is what they would be "
     "without."},
    {kTerm, "coverage", "covered, covered fraction, within tolerance",
     "Which share of the floor hears so many beacons, or has a fix, or one within tolerance.fix_m: what "
     "stands "
     "beside the figure says which."},
    {kTerm, "cycle", "slot, firing schedule, fires at",
     "Who sends when, so that no pulse meets the echo of another: beacons of one slot fire together, and "
     "after "
     "a cycle it begins anew. octant plan --schedule makes it."},
    {kTerm, "datum", "frame, scale, orientation, shift: see the datum",
     "What ties the map to the building: which points fix its position, its orientation and its scale. "
     "Without three "
     "control points (or other ties) the beacons' shape is known, but not where it lies; two calibrations "
     "with "
     "different datums differ by a shift and a turn that mean nothing."},
    {kTerm, "delay", "electronic delay, delay_s",
     "Time that electronics add to each arrival: measured time less true time of flight. 100 us are 34 mm "
     "in air. "
     "Calibration finds one for each beacon, receiver or site, as timing.delay_per says."},
    {kTerm, "degraded", "not_protected, beacon_fault",
     "A fix whose error nothing bounds (not_protected), or from which a beacon that contradicts all others "
     "was "
     "left out (beacon_fault)."},
    {kTerm, "deployment", "deployment file, deployment.json",
     "What calibrate writes and a robot reads: places, delays, speed, receivers, and how well each is "
     "known."},
    {kTerm, "dilution of precision", "dop, dilution, hdop, pdop, gdop, vdop, tdop",
     "How many times larger the error of a fix is than that of one range, by the geometry alone. HDOP is "
     "that of the "
     "position in the plane: 1 is good, above 4 the beacons stand too much to one side."},
    {kTerm, "drift", "drift/year, beacon_drift_m_per_month",
     "What a number may have changed since the calibration without anything having happened: walls work, "
     "electronics age."},
    {kTerm, "echo", "echoes, reflection, nlos",
     "A pulse that came by way of a wall: it is late, never early. Octant leaves echoes out by their "
     "residual."},
    {kTerm, "epoch", "epochs, stop, stops",
     "One pose of the vehicle with all that was heard there. Rows of tof.csv with the same number in the "
     "column epoch "
     "were taken while the vehicle stood still. Without the column the vehicle is taken to move all the "
     "time."},
    {kTerm, "error ellipse", "ellipse, 95 % a, 95 % ellipse a, a, b, azimuth",
     "Where the true place in the plane lies with 95 per cent: half axes a and b, and the direction of a."},
    {kTerm, "expanded uncertainty", "u, u x, u y, u z, u delay, 95 %",
     "Twice the sigma (k = 2): 95 in 100 errors are smaller. A control point has none: it is held fixed, and "
     "its own error is not among these figures."},
    {kTerm, "expected error",
     "expected error of a fix, total_m, calibration_m, speed_part_m, without, if gone",
     "How far off a fix will be there (one standard deviation in the plane): by the noise of its arrivals, "
     "by "
     "what the calibration does not know, or by both. Without a beacon: when that one is silent."},
    {kTerm, "fix", "fixes, no fix",
     "A pose of the vehicle found from the arrivals of one epoch (or instant). No fix: the arrivals do not "
     "agree or "
     "do not suffice; the reason is its status."},
    {kTerm, "gate", "gates, gate kept, limit, gate fix_m, kept",
     "A limit that a result is held against: kept or not. tolerance in the site file sets them; the "
     "verdict is Good "
     "only if all are kept."},
    {kTerm, "incidence", "",
     "The angle at which an arrival comes: off the receiver's axis where the site file gives one, else off "
     "the "
     "vertical. Residuals that grow with it are the receiver's, not the room's."},
    {kTerm, "influence", "moves, moves [mm], one arrival moves it",
     "How far an error just too small to be found would move the beacon. Small is good: then undetected "
     "errors do "
     "no harm."},
    {kTerm, "iterations", "iteration, converged",
     "Steps of the adjustment until nothing changes any more. Many are no fault; not converged is (exit "
     "4)."},
    {kTerm, "lateness", "all late, that moves it",
     "All arrivals of a beacon late by the same: the smallest lateness that the adjustment would notice, and "
     "how far a smaller one may move the beacon. A delay that is free takes it up; then the delay's prior "
     "notices."},
    {kTerm, "lever arm", "receiver's place",
     "Where a receiver sits on the vehicle, seen from the vehicle's origin. An error of it turns with the "
     "vehicle."},
    {kTerm, "longest silence", "rate, arrivals a second",
     "How long a beacon was not heard, and how often it was heard on average. A long silence is a shadow, or "
     "a "
     "beacon that stopped sending."},
    {kTerm, "mdb", "minimal detectable bias, mdb_s, detectable_bias_m",
     "The smallest error of one arrival that the test would find in 80 of 100 cases (Baarda). Small is "
     "good. It is "
     "large where few other arrivals check this one."},
    {kTerm, "medium", "speed, speed of sound, speed_mps",
     "What the signal runs through, and how fast. In air 343 m/s at 20 degC, and 0.6 m/s more for each "
     "degree: a "
     "range of 10 m changes by 18 mm for each degree that nobody accounts for."},
    {kTerm, "misfit", "heard, misfit_s",
     "By how much the arrivals of a beacon or receiver come later (+) or earlier (-) than the deployment "
     "foretells."},
    {kTerm, "moved from the site file", "how wrong was my tape, moved most, moved from site, dx, dy, dz",
     "How far each beacon was found from where the site file has it. Within two or three of the sigma that "
     "you "
     "stated is as expected; far beyond it means a slip of the tape, or two labels exchanged."},
    {kTerm, "nees", "nees_mean, normalised estimation error squared",
     "Squared errors against truth, each divided by its stated variance, over the number of coordinates. "
     "1: the "
     "stated sigmas are honest. 4: errors are twice as large as stated. Below 1: stated too carefully."},
    {kTerm, "odometry", "odometry.csv, odometry.tum",
     "How the vehicle moved from row to row, by wheels, an inertial unit or a camera: each row is a pose in "
     "the frame of the row before, of a drone or a hand-held rig in space. odometry.tum has the same as a "
     "track in a frame of its own."},
    {kTerm, "p", "chi2_p, p value, p =, chance",
     "How likely chance alone makes a figure as odd as this one. Below 0.001 it is not chance. With very "
     "many "
     "arrivals small, harmless misfits become certain too: then look at the variance factor's size, not at "
     "p."},
    {kTerm, "position error", "heading error, rmse, largest",
     "How far fixes are from the reference. RMSE: their usual size; 95 %: so many are closer; largest: the "
     "worst "
     "of all."},
    {kTerm, "prior", "priors, sigma_m, delay_sigma_s, sigma_mps",
     "What you know beforehand, with its sigma: how far off it may be (one standard deviation; two in "
     "three lie "
     "within it, 95 in 100 within two). Say what is true, not what you wish: a sigma too small makes a "
     "contradiction (exit 6), one that is too large only costs arrivals."},
    {kTerm, "protection level", "protection_level_m, protection_m, integrity",
     "A bound that the error of a fix exceeds only once in very many times, undetected echoes included. A "
     "robot "
     "stops where it is larger than its safety margin."},
    {kTerm, "reach", "range_m",
     "How far a beacon is heard. It follows from amplitude, absorption and threshold, or is stated as "
     "range_m; "
     "where nothing says it, every beacon is taken as heard everywhere, which is too good to be true."},
    {kTerm, "receiver", "receivers, microphone, tag",
     "A device on the vehicle that hears beacons (or is heard by them: the equations are the same)."},
    {kTerm, "redundancy", "redundancy number, r, reliability",
     "Observations beyond what the unknowns need. Of one arrival: which part of its error shows in its "
     "residual, 0 "
     "(not checked at all) to 1. Good calibrations have 0.5 and more on average."},
    {kTerm, "residual", "residuals, rms, rms_s, mean, count, looked at",
     "What an arrival differs by from what the found places, delays and speed explain. RMS is their usual "
     "size; it "
     "should be near noise.tof_sigma_s."},
    {kTerm, "route", "routes, along the routes",
     "A line that vehicles drive, stated in the scene: a survey looks at the poses along it, headings "
     "included."},
    {kTerm, "run", "recording, run folder",
     "A folder with one recording: tof.csv and what belongs to it. octant schema run explains all files."},
    {kTerm, "sigma",
     "sigmas, sigma x, sigma y, sigma z, sx, sy, sz, s, s delay, known to, stated within, standard "
     "deviation, uncertainty",
     "One standard deviation: two in three errors are smaller, 95 in 100 are smaller than two of it. "
     "Figures marked "
     "95 % have that factor in them already."},
    {kTerm, "site", "site file, site.yaml",
     "A place with beacons; the site file says what is known of it before a calibration. octant init "
     "writes one to "
     "fill in."},
    {kTerm, "status", "calibrated",
     "Of a beacon: calibrated, control point (held where the site file has it) or undetermined. Of a fix: "
     "ok, or "
     "why there is none."},
    {kTerm, "time of flight", "tof, tof_s",
     "How long a pulse took from beacon to receiver, in seconds: 10 ms are 3.4 m of air."},
    {kTerm, "time walk", "time-walk, rise time, threshold",
     "A weak pulse crosses the receiver's threshold later than a strong one. Octant calibrates it where "
     "the site "
     "file has an attenuation block."},
    {kTerm, "tolerance", "beacon_m, fix_m",
     "What the site must reach: the largest error of a beacon and of a fix that its use can bear. You "
     "choose it."},
    {kTerm, "undetermined", "undetermined beacon",
     "The recording does not tell where this beacon is, or not well enough: it was not heard, or only from "
     "one side. "
     "It is written with that status, and localizers leave it out. Hear it from stops spread around it."},
    {kTerm, "unknowns", "unknown",
     "Numbers to be found: coordinates, delays, the speed, and the vehicle's pose at each stop."},
    {kTerm, "variance factor", "variance_factor, variance components, variances, variance",
     "How large the squared residuals are against what the stated sigmas expect. 1: as stated. 1.3: "
     "residuals are 14 "
     "per cent larger than stated (its root); state noise.tof_sigma_s as it is, and nothing else is "
     "needed. 4 and "
     "more: something is wrong, not just noisy: see the warnings, the residuals by beacon and by "
     "receiver."},
    {kTerm, "verdict", "grade",
     "The answer in one word and a sentence: Good, Not good enough, Contradicted or Refused."},
    {kTerm, "w", "baarda, baarda's w, critical w",
     "A residual over its own sigma: its size in standard deviations. Beyond 4 it is a mistake, not "
     "noise."},
    {kTerm, "weak", "weak direction, weak directions",
     "Something that the data know worse than the rest, with the measurement that would settle it."},
    {kTerm, "what if", "what-if",
     "What becomes of fixes if the air is warmer by so much and nobody says so."},
    {kGrade, "good", "", "All gates are kept and nothing contradicts: use it."},
    {kGrade, "not good enough", "",
     "The result is right as far as the data know, and worse than the tolerance asks for (exit 0). Follow "
     "the next "
     "steps: more stops, better spread, another control point."},
    {kGrade, "contradicted", "contradiction",
     "The data say that something in the site file is wrong beyond chance (exit 6). The message names it: "
     "measure it "
     "again, correct the site file, calibrate again. --accept exports it all the same, marked."},
    {kGrade, "refused", "",
     "The data cannot determine something that all else hangs on (exit 5). Nothing is exported; the "
     "message names "
     "the measurement that settles it."},
    {kReason, "late", "late (echo)",
     "Later than the rest explains: an echo. A beacon whose arrivals are mostly late stands behind "
     "something."},
    {kReason, "early", "early (spurious)",
     "Earlier than the rest explains, which no echo can be: another beacon's pulse, noise, or a receiver "
     "that is "
     "wired to another channel."},
    {kReason, "beacon undetermined", "", "Its beacon's place is not known, so it tells nothing."},
    {kReason, "no vehicle pose at its time", "no pose",
     "Nothing tells where the vehicle was then: before the first odometry row, or a stop with too few "
     "arrivals."},
    {kReason, "breaks the triangle inequality", "triangle",
     "Two beacons are a known distance apart; these two ranges cannot both be straight (Kleeman)."},
    {kReason, "farther or nearer than is possible", "out of range",
     "Outside of gates.min_range_m and gates.max_range_m of the site file."},
    {kReason, "right behind another of its beacon", "reflection of it",
     "The same beacon was heard a moment before: this is its reflection."},
    {kReason, "outvoted", "", "It disagrees with most others of its epoch."},
    {kReason, "not needed", "", "The chosen method fixes the pose from others. No fault."},
    {kReason, "too few arrivals", "",
     "Fewer arrivals than unknowns: no fix. Add beacons, or drive where more are heard."},
    {kReason, "poor geometry", "", "The beacons that were heard stand in one line or one direction: no fix."},
    {kReason, "ambiguous", "mirror, mirror image",
     "Two poses explain the arrivals equally well, mostly mirror images: no fix. A beacon off the line, or "
     "another "
     "receiver, decides."},
    {kReason, "no consensus", "",
     "Too many arrivals disagree: no fix. Echoes, or a deployment that no longer fits (octant monitor "
     "tells)."},
    {kReason, "not converged", "not_converged", "The search found no end. Are units and ids right?"},
    {kReason, "exchanged", "labels",
     "Two beacons stand at each other's places: look at the labels on the wall, correct the site file."},
    {kReason, "wiring", "",
     "Receivers are exchanged, mirrored or turned against the site file: check the plugs."},
    {kReason, "units", "unit",
     "Positions, sigmas or times seem to be in another unit: feet, centimetres, milliseconds."},
    {kReason, "ranging", "two_way, one_way",
     "Times there and back were taken for one way: timing.ranging: two_way."},
    {kReason, "repeated", "", "Rows stand in the recording more than once."},
    {kExit, "0", "done, ok",
     "Done. A result that is worse than the tolerance is done too; its grade says so."},
    {kExit, "1", "fault", "A fault of the program: please report it, with the command and the message."},
    {kExit, "2", "usage", "Wrong usage: a word of the command line is wrong; nothing was read or written."},
    {kExit, "3", "bad input",
     "A file is wrong; the message names file, line, what was found and what was expected."},
    {kExit, "4", "the solver did not converge",
     "The adjustment found no end. Units, ids or approximate positions are wrong, most likely: octant "
     "check tells."},
    {kExit, "5", "undetermined data",
     "The data cannot determine something that all else hangs on; nothing was written. The message names "
     "the "
     "measurement that settles it."},
    {kExit, "6", "gate failed, quality gate",
     "verify: a gate was not kept. calibrate, recalibrate: the data contradict the site file. monitor: "
     "something no "
     "longer fits. The message names it."},
    {kExit, "130", "interrupted", "Interrupted by you; nothing half-written stays behind."}};

}  // namespace

const std::vector<GlossaryTerm>& glossary() {
  static const std::vector<GlossaryTerm> terms(std::begin(kGlossary), std::end(kGlossary));
  return terms;
}

namespace {

/// Whether a test holds of a term's name or of one of its other spellings.
template <class Test>
bool any_spelling(const GlossaryTerm& term, const Test& holds) {
  if (holds(std::string_view(term.name))) return true;
  for (std::string_view others = term.others; !others.empty();) {
    const std::size_t end = std::min(others.find(','), others.size());
    if (holds(others.substr(0, end))) return true;
    others.remove_prefix(std::min(end + 1, others.size()));
  }
  return false;
}

/// Lower case, blanks for all but letters, digits and what stands between columns.
std::string only_words(std::string_view text) {
  std::string out = " ";
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    out += std::isalnum(u) != 0 || c == '|' || c == '%' ? static_cast<char>(std::tolower(u)) : ' ';
    if (out.size() > 1 && out.back() == ' ' && out[out.size() - 2] == ' ') out.pop_back();
  }
  return out + " ";
}

bool has_spelling(const std::string& words, std::string_view spelling) {
  constexpr std::size_t kShort = 2;  // letters of a spelling that is a word of its own in a heading alone
  std::string wanted = only_words(spelling);
  if (wanted.size() <= 2) return false;
  if (wanted.size() - 2 <= kShort) wanted = "|" + wanted;
  return words.find(wanted) != std::string::npos;
}

}  // namespace

const GlossaryTerm* find_term(std::string_view word) {
  const std::string wanted = plain(word);
  for (const GlossaryTerm& term : glossary())
    if (any_spelling(term, [&](std::string_view spelling) { return plain(spelling) == wanted; }))
      return &term;
  return nullptr;
}

std::vector<const GlossaryTerm*> terms_used(std::string_view text) {
  const std::string words = only_words(text);
  std::vector<const GlossaryTerm*> used;
  for (const GlossaryTerm& term : glossary())
    if (any_spelling(term, [&](std::string_view spelling) { return has_spelling(words, spelling); }))
      used.push_back(&term);
  return used;
}

std::string glossary_page() {
  std::string page =
      "# Words\n\nWhat the outputs say, in a paragraph each; `octant explain WORD` prints one of them.\n";
  const char* last = "";
  for (const GlossaryTerm& term : glossary()) {
    if (heading(term.kind) != last) page += fmt::format("\n## {}\n", last = heading(term.kind));
    page += fmt::format("\n**{}**{}. {}\n", term.name,
                        term.others.empty() ? "" : fmt::format(" ({})", term.others), term.text);
  }
  return page;
}

}  // namespace octant::app
