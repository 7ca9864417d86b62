#!/usr/bin/env bash
# The weights v0: six styles of Bandai-Namco set 2, from random weights. 84 minutes on one core. Wall
# time ends the run, so that another machine gets other weights of the same kind.
. "$(dirname "$0")/recipe.sh"

train v0 --minutes 75 --stop-at 23500 --seed 1
# A weaker smoothness term and a stronger critic.
train v0 --minutes 84 --seed 1 --resume --w-smooth 4 --w-penalty 40
