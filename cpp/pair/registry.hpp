// The list of all pair laws and the ways to find one; a new law is one header and one line here.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "pair/born_huggins_meyer.hpp"
#include "pair/buckingham.hpp"
#include "pair/dpd.hpp"
#include "pair/fourteen_seven.hpp"
#include "pair/hydrogen_bond.hpp"
#include "pair/law.hpp"
#include "pair/lennard_jones.hpp"
#include "pair/lennard_jones_cohesive.hpp"
#include "pair/lennard_jones_frenkel.hpp"
#include "pair/mdpd.hpp"
#include "pair/morse.hpp"
#include "pair/morse_twelve.hpp"
#include "pair/n_m.hpp"
#include "pair/n_m_shifted.hpp"
#include "pair/ndpd.hpp"
#include "pair/rydberg.hpp"
#include "pair/sanderson.hpp"
#include "pair/stillinger_weber.hpp"
#include "pair/tabulated.hpp"
#include "pair/tapered_buckingham.hpp"
#include "pair/tapered_lennard_jones.hpp"
#include "pair/tapered_twelve_six.hpp"
#include "pair/twelve_six.hpp"
#include "pair/weeks_chandler_andersen.hpp"
#include "pair/zbl.hpp"
#include "pair/zbl_buckingham.hpp"
#include "pair/zbl_morse.hpp"

namespace dlpoly::pair {

template <class... Types>
struct TypeList {};

using Laws = TypeList<LennardJones,           //
                      TwelveSix,              //
                      LennardJonesCohesive,   //
                      LennardJonesFrenkel,    //
                      NM,                     //
                      NMShifted,              //
                      Buckingham,             //
                      BornHugginsMeyer,       //
                      HydrogenBond,           //
                      Morse,                  //
                      MorseTwelve,            //
                      WeeksChandlerAndersen,  //
                      Dpd,                    //
                      NDpd,                   //
                      ManyBodyDpd,            //
                      FourteenSeven,          //
                      Rydberg,                //
                      Zbl,                    //
                      ZblMorse,               //
                      ZblBuckingham,          //
                      TaperedLennardJones,    //
                      TaperedBuckingham,      //
                      TaperedTwelveSix,       //
                      Sanderson,              //
                      StillingerWeber,        //
                      Tabulated>;

// Calls f.template operator()<Law>() for every law, in the order of the list.
template <class Function>
void for_each_law(Function&& f) {
    [&]<class... Law>(TypeList<Law...>) { (f.template operator()<Law>(), ...); }(Laws{});
}

// The record of a key in lower case, or nullptr.
inline const LawInfo* find(std::string_view key) {
    const LawInfo* found = nullptr;
    for_each_law([&]<class Law>() {
        if (Law::info.key == key) found = &Law::info;
    });
    return found;
}

// Calls f.template operator()<Law>() for the law of this key; an unknown key throws std::invalid_argument.
template <class Function>
void visit(std::string_view key, Function&& f) {
    bool found = false;
    for_each_law([&]<class Law>() {
        if (!found && Law::info.key == key) {
            found = true;
            f.template operator()<Law>();
        }
    });
    if (!found) throw std::invalid_argument("unknown pair law '" + std::string(key) + "'");
}

// One law from whatever its record holds: numbers for all, a table for tab.
template <class Law>
Law make(std::span<const double> parameters, double cutoff, const std::shared_ptr<const Table>& table = nullptr) {
    if constexpr (std::is_same_v<Law, Tabulated>) {
        if (!parameters.empty()) throw std::invalid_argument("pair law tab takes a table and no numbers");
        return Tabulated::make(table, cutoff);
    } else {
        if (table) throw std::invalid_argument("pair law " + std::string(Law::info.key) + " takes no table");
        return Law(parameters, cutoff);
    }
}

}  // namespace dlpoly::pair
