"""Looks at the master each second, which are to cost a node's loop next to nothing."""

import threading
import xmlrpc.server

import pytest

from mrs_simulator.ros.node.master import Transport, asked


class Counting(Transport):
    parsed = 0

    def getparser(self):
        self.parsed += 1
        return super().getparser()


@pytest.fixture
def served():
    """Return an address that is asked ``state``, and the list that it answers."""
    answer = [["/robot{}/odom".format(number), ["/stage"]] for number in range(200)]
    with xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(lambda name: (1, "", answer), "state")
        thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
        thread.start()
        yield "http://127.0.0.1:{}".format(server.server_address[1]), answer
        server.shutdown()
        thread.join()


def test_an_answer_is_read_again_only_where_it_has_changed(served):
    address, answer = served
    transport, told = Counting(), []
    for look in range(6):
        if look == 4:
            answer.append(["/clock", ["/stage", "/gazebo"]])
        told.append(dict(asked(address, transport, "state")))
    assert transport.parsed == 2
    assert [len(each) for each in told] == [200, 200, 200, 200, 201, 201]
    assert told[-1]["/clock"] == ["/stage", "/gazebo"]


def test_an_error_is_told_each_time(served):
    transport = Counting()
    for _ in range(2):
        with pytest.raises(Exception, match="nothing"):
            asked(served[0], transport, "nothing")
