#pragma once
// An operation as tables for a statistician's program: CSV with a line of names, a point for decimals, no thousands.
//
//   measures.csv   moment,t_s,state_hash, then every figure of `limberg measures` that is one number, by its name;
//                  empty where it does not apply
//   forces.csv     t_s,moment,kind,id,thread,force_N,gap_mm,x_mm,y_mm,z_mm: each stitch (at its middle) and hook (at
//                  the skin; its gap is the way from there to its handle), at every moment and frame
//   hands.csv      t_s,hand,tool,pressed,x_mm,y_mm,z_mm,shaft_x,shaft_y,shaft_z: the tip at every solver step of a
//                  recording while it is tracked; hand: stylus, glove, other glove (whose place is between the fingers)
#include <string>

#include "app/session/channels.h"
#include "sim/measure/metrics.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class ExportTables {
 public:
  void moment(double t_s, const std::string& name, const std::string& state_hash, const Metrics& metrics);
  void forces(double t_s, const std::string& name, const Snapshot& snapshot);
  void hands(double t_s, const HandState& hands);

  /// With their line of names; empty: nothing was added.
  const std::string& measures() const { return measures_; }
  const std::string& forces() const { return forces_; }
  const std::string& hands() const { return hands_; }

 private:
  std::string measures_, forces_, hands_;
};

}  // namespace limberg
