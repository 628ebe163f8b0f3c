"""Ctrl-C during a simulation: at once while nothing is recorded, between two blocks afterwards."""

import os
import signal
import threading

import pytest

from flexmb.cli.interruption import Interruption


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_waits_for_the_next_look(number):
    with Interruption() as interruption:
        interruption.look()
        os.kill(os.getpid(), number)
        with pytest.raises(KeyboardInterrupt):
            interruption.look()


def test_before_the_first_look_it_is_immediate():
    with Interruption(), pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)


def test_the_second_time_is_immediate():
    with Interruption() as interruption:
        interruption.look()
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


def test_handlers_are_put_back():
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with Interruption():
        pass
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_another_thread_has_no_signals():
    done = []

    def work():
        with Interruption() as interruption:
            interruption.look()
        done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [True]
